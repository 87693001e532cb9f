"""The experiment of an atlas."""

import pytest

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.experiment.overrides import Typed
from gaitsim.registry import options
from gaitsim_adaptation.atlas import load_atlas

LEGS = ["L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4"]


def test_it_is_the_preset_of_the_body_if_there_is_one():
    found = load_atlas("spider", set={"seed": 3})
    assert found.to_toml() == load_experiment("spider-atlas", {"seed": 3}).to_toml()
    assert load_atlas("spider-atlas").to_toml() == load_experiment("spider-atlas").to_toml()


def test_it_is_derived_from_the_experiment_of_a_body_with_legs():
    given = {"evolution.stagnation": 5, "organism.encoding": "cpg"}
    found = load_atlas("spider-genetic", cells=700, set={**given, "search.sigma": Typed("0.1")})
    assert found.name == "spider-genetic-atlas"
    search = options.values(found.search)
    assert search["axes"] == {f"duty factor {leg}": [0, 1] for leg in LEGS}
    assert (search["cells"], search["sigma"]) == (700, 0.1)
    organism = options.values(found.organism)
    assert (organism["encoding"], organism["symmetry"]) == ("cpg", "none")
    assert found.evolution.stagnation == 5
    assert options.values(load_atlas("spider-genetic").search)["cells"] == 15_625
    two = load_atlas("spider-genetic", axes={"duty factor": None, "yaw": (-90, 90)}, cells=(4, 5))
    assert options.values(two.search)["axes"] == {"duty factor": [0, 1], "yaw": [-90, 90]}
    typed = load_atlas("spider-genetic", set={"search.axes": Typed("{ yaw = [0, 9] }")})
    assert options.values(typed.search)["axes"] == {"yaw": [0, 9]}


def test_conditions_on_the_best_score_do_not_stop_it(tmp_path):
    file = tmp_path / "mine.toml"
    text = load_experiment("spider-genetic", {"evolution.target_score": 1.0}).to_toml()
    file.write_text(text)
    assert load_atlas(str(file)).evolution.target_score is None


def test_mistakes_are_reported():
    with pytest.raises(GaitsimError, match="no range is given"):
        load_atlas("spider-genetic", axes={"yaw": None})
    with pytest.raises(ExperimentError, match="2 counts for 8 axes"):
        load_atlas("spider-genetic", cells=(3, 4))
    with pytest.raises(ExperimentError, match="must be from"):
        load_atlas("spider-genetic", axes={"yaw": (-1e308, 1e308)})
    with pytest.raises(GaitsimError, match="no legs") as caught:
        load_atlas("millipede")
    assert caught.value.allowed
