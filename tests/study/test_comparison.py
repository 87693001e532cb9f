import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides
from gaitsim.study.comparison import (
    Sample,
    analyse,
    load_experiments,
    methods,
    report,
    results,
    to_dict,
)
from gaitsim.study.running import repeat_experiment

SHORT = {"evolution.population": 9, "evolution.generations": 12}


def compared(*names: str, target: float | None = None, more: Overrides | None = None):
    loaded = load_experiments(names, SHORT | (more or {}))
    return analyse({k: Sample(e, repeat_experiment(e, 40)) for k, e in loaded.items()}, target)


def test_equal_experiments_do_not_differ() -> None:
    found = compared("millipede-double-mutation", "millipede-double-mutation")
    (pair,) = found.comparisons
    assert (pair.first, pair.second) == (
        "millipede-double-mutation",
        "millipede-double-mutation (2)",
    )
    assert not pair.differs
    one, other = found.samples.values()
    assert one.experiment.seed != other.experiment.seed
    assert not np.array_equal(one.final, other.final)


def test_a_large_difference_is_found() -> None:
    longer = {"evolution.population": 35, "evolution.generations": 37}
    found = compared("millipede-random", "millipede-crossover", "millipede", more=longer)
    assert len(found.comparisons) == 3
    pair = found.comparisons[0]
    assert pair.differs
    assert pair.effect == "large"


def test_the_default_target_is_the_lowest_median() -> None:
    found = compared("millipede-random", "millipede-crossover")
    lowest = min(one.median for one in found.descriptions.values())
    assert {one.target for one in found.reached.values()} == {lowest}
    assert compared("millipede-random", "millipede", target=99).reached["millipede"].rate == 0


def test_report_and_json_hold_the_figures() -> None:
    found = compared("millipede-random", "millipede-mutation", target=3.0)
    text = report(found, "gaitsim compare a b")
    for piece in ("| millipede-random | 40 |", "A12", "ERT", "gaitsim compare a b", "Holm"):
        assert piece in text
    assert methods(found) in text
    values = to_dict(found)
    assert values["experiments"]["millipede-random"]["mean"] == pytest.approx(
        found.samples["millipede-random"].final.mean()
    )
    assert values["comparisons"][0]["a12"] == found.comparisons[0].a12
    rows = results(found).splitlines()
    assert rows[0] == "experiment,repeat,generation,evaluations,best"
    assert len(rows) == 1 + 2 * 40 * 12
    individuals = found.samples["millipede-random"].experiment.individuals
    assert rows[12].startswith(f"millipede-random,1,12,{12 * individuals},")


def test_one_experiment_is_not_enough() -> None:
    with pytest.raises(GaitsimError, match="cannot be compared"):
        load_experiments(["spider"], [])


def test_a_repeat_without_a_score_is_reported() -> None:
    loaded = load_experiments(["millipede", "millipede-random"], SHORT)
    samples = {k: Sample(e, repeat_experiment(e, 3)) for k, e in loaded.items()}
    samples["millipede"].best[:] = -np.inf
    with pytest.raises(GaitsimError, match="every individual failed"):
        analyse(samples, None)
