import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides, with_overrides
from gaitsim.study.comparison import (
    Sample,
    analyse,
    equal_budgets,
    load_experiments,
)
from gaitsim.study.comparison_report import curves, methods, report, results, to_dict
from gaitsim.study.running import repeat_experiment

SHORT = {"evolution.population": 9, "evolution.generations": 12}


def compared(*names: str, targets: tuple[float, ...] = (), more: Overrides | None = None):
    budget, loaded = equal_budgets(load_experiments(names, SHORT | (more or {})), None)
    samples = {k: Sample(e, repeat_experiment(e, 40)) for k, e in loaded.items()}
    return analyse(samples, budget, targets)


def test_equal_experiments_do_not_differ() -> None:
    found = compared("millipede-double-mutation", "millipede-double-mutation")
    (pair,) = found.pairs
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
    assert len(found.pairs) == 3
    pair = found.pairs[0]
    assert pair.differs
    assert pair.effect == "large"


def test_the_default_targets_are_the_medians() -> None:
    found = compared("millipede-random", "millipede-crossover")
    medians = sorted(one.median for one in found.descriptions.values())
    for reached in found.reached.values():
        assert [one.target for one in reached] == medians
    (never,) = compared("millipede-random", "millipede", targets=(99,)).reached["millipede"]
    assert never.rate == 0


def test_experiments_of_other_populations_have_equal_budgets() -> None:
    one, other = load_experiments(["millipede", "millipede-random"], SHORT).values()
    other = with_overrides(other, {"evolution.population": 41})
    sizes = one.individuals, other.individuals
    assert sizes[0] < sizes[1] < 12 * sizes[0]
    budget, short = equal_budgets({"a": one, "b": other}, None)
    assert budget == 12 * sizes[0]  # the whole of the first one
    lengths = [e.evolution.generations for e in short.values()]
    assert lengths == [12, budget // sizes[1]]
    samples = {k: Sample(e, repeat_experiment(e, 5)) for k, e in short.items()}
    found = analyse(samples, budget, ())
    assert budget - sizes[1] < samples["b"].evaluations[-1] <= budget == found.evaluations
    # A generation of the whole budget is allowed, a larger one is not.
    assert equal_budgets({"a": one, "b": other}, sizes[1])[1]["b"].evolution.generations == 1
    with pytest.raises(GaitsimError, match="fewer than a generation of b") as caught:
        equal_budgets({"a": one, "b": other}, sizes[1] - 1)
    assert str(sizes[1]) in caught.value.allowed


def test_report_and_json_hold_the_figures() -> None:
    found = compared("millipede-random", "millipede-mutation", targets=(3.0, 4.0))
    text = report(found, "gaitsim compare a b", [])
    for piece in ("after 108 evaluations, 40 repeats", "A12", "ERT", "gaitsim compare a b", "Holm"):
        assert piece in text
    assert methods(found) in text
    values = to_dict(found)
    assert values["experiments"]["millipede-random"]["mean"] == pytest.approx(
        found.samples["millipede-random"].final.mean()
    )
    assert values["comparisons"][0]["a12"] == found.pairs[0].a12
    assert [one["target"] for one in values["experiments"]["millipede-random"]["ert"]] == [3, 4]
    share = found.ecdfs["millipede-random"].share
    assert curves(found).splitlines()[12].endswith(f",{share[-1]}")
    rows = results(found).splitlines()
    assert rows[0] == "experiment,repeat,generation,evaluations,best"
    assert len(rows) == 1 + 2 * 40 * 12
    individuals = found.samples["millipede-random"].experiment.individuals
    assert rows[12].startswith(f"millipede-random,1,12,{12 * individuals},")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"experiments": "millipede"}, "one experiment cannot be compared"),
        ({"repeats": 1}, "1 is not a number of repeats"),
        ({"evaluations": 9.5}, "9.5 is not a number of evaluations"),
        ({"evaluations": 8}, "fewer than a generation"),
        ({"evaluations": 10**12}, "not allowed: generations"),
        ({"targets": [1, float("inf")]}, "inf is not a score"),
        ({"targets": "high"}, "'high' is not a score"),
    ],
)
def test_mistakes_are_told_before_anything_is_evolved(arguments, says) -> None:
    with pytest.raises(GaitsimError, match=says):
        gs.compare(**{"experiments": ["millipede", "millipede"], "set": SHORT} | arguments)


def test_in_python_it_is_the_same_comparison() -> None:
    names = ["millipede-random", "millipede-mutation"]
    found = gs.compare(names, repeats=40, set=SHORT, targets=[3.0])
    same = compared(*names, targets=(3.0,))
    assert to_dict(found) == to_dict(same)
    assert found.plot("convergence").axes[0].get_xlim() == (0, found.evaluations)
    with pytest.raises(GaitsimError, match="convergence, ecdf"):
        found.plot("surface")


def test_a_repeat_without_a_score_is_reported() -> None:
    loaded = load_experiments(["millipede", "millipede-random"], SHORT)
    samples = {k: Sample(e, repeat_experiment(e, 3)) for k, e in loaded.items()}
    samples["millipede"].best[:] = -np.inf
    with pytest.raises(GaitsimError, match="every individual failed"):
        analyse(samples, 100)
