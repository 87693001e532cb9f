"""Studies never reuse a result of a different experiment."""

from dataclasses import replace

import pytest

from gaitsim.experiment import load_experiment, with_overrides
from gaitsim.registry import options
from gaitsim_studies.file import cells, parse_study
from gaitsim_studies.running import result_key, results

REALITY = {
    "search.plugin": "nsga-2",
    "search.objectives": {"score": "max", "transferability": "max"},
    "transferability.reality": {"world": {"friction": 0.2}},
}
CHANGES = [
    ("spider-genetic", {}, {"selection.size": 5}),
    ("spider-genetic", {}, {"crossover.plugin": "none"}),
    ("spider-genetic", {}, {"mutation.rate": 0.9}),
    ("walker", {}, {"worlds.number": 3}),
    ("walker", {"worlds.number": 3}, {"worlds.combine": "worst"}),
    ("walker", REALITY, {"transferability.every": 2}),
    ("walker", REALITY, {"transferability.reality": {"world": {"friction": 0.3}}}),
    ("walker", REALITY, {"search.objectives": {"score": "max", "transferability": "min"}}),
]


def key(experiment, repeats=10, generations=(5, 10)):
    return result_key(experiment, repeats, generations)


@pytest.mark.parametrize(("name", "given", "change"), CHANGES, ids=lambda one: str(one)[:50])
def test_the_key_depends_on_each_section(name, given, change):
    one = load_experiment(name, given)
    assert key(one) == key(load_experiment(name, given))
    assert key(one) != key(with_overrides(one, change))


def test_the_key_depends_on_every_number():
    one = load_experiment("walker", {"worlds.number": 3})
    keys = [key(one)]
    for section, model in one.sections().items():
        for name, value in options.values(model).items():
            if type(value) in (int, float):
                changed = model.model_copy(update={name: value + 1})
                keys.append(key(replace(one, **{section: changed})))
    assert len(keys) > 15
    assert len({*keys}) == len(keys)


def test_the_key_depends_on_repeats_and_recorded_generations():
    one = load_experiment("millipede")
    assert len({key(one), key(one, repeats=11), key(one, generations=(10,))}) == 3


def test_the_key_depends_on_versions_of_libraries_and_requirements(monkeypatch):
    one = load_experiment("millipede")
    keys = {key(one)}
    monkeypatch.setattr("gaitsim_studies.running._requirements", lambda package: ("jax",))
    keys.add(key(one))
    monkeypatch.setattr("gaitsim_studies.running._version", lambda package: "99.0")
    keys.add(key(one))
    assert len(keys) == 3


STUDY = """
name = "rates"
experiments = ["millipede-mutation"]
set = { "evolution.generations" = 4, "evolution.population" = 5 }
repeats = 3
[axes]
"mutation.count" = [1, 2]
"organism.pairs" = [3]
"""


@pytest.mark.slow
def test_a_study_edited_in_its_folder_reruns_its_cells(gaitsim, tmp_path):
    (tmp_path / "rates.toml").write_text(STUDY)
    assert "2 of 2 cells to run" in gaitsim("study", "rates.toml", "--workers", 1).stderr
    folder = tmp_path / "studies/rates"
    before = (folder / "results.csv").read_text()
    (folder / "study.toml").write_text(STUDY.replace("[1, 2]", "[5, 9]"))
    assert "2 of 2 cells to run" in gaitsim("study", "studies/rates", "--workers", 1).stderr
    assert (folder / "results.csv").read_text() != before
    assert results(folder, parse_study(STUDY, "s"), cells(parse_study(STUDY, "s")))[1] == []
