import json

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.console.printing import as_json
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides, with_overrides
from gaitsim_studies.comparing import Comparison
from gaitsim_studies.comparison import Sample, analyse, equal_budgets, load_experiments
from gaitsim_studies.comparison_report import methods, report, to_dict
from gaitsim_studies.running import repeat_experiment

SHORT = {"evolution.population": 9, "evolution.generations": 12}


def compare_experiments(
    *names: str, targets: tuple[float, ...] = (), more: Overrides | None = None, repeats: int = 40
):
    budget, loaded = equal_budgets(load_experiments(names, SHORT | (more or {})), None)
    samples = {k: Sample(e, repeat_experiment(e, repeats)) for k, e in loaded.items()}
    return analyse(samples, budget, targets)


def test_equal_experiments_do_not_differ() -> None:
    found = compare_experiments("millipede-double-mutation", "millipede-double-mutation")
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
    found = compare_experiments("millipede-random", "millipede-crossover", "millipede", more=longer)
    assert len(found.pairs) == 3
    pair = found.pairs[0]
    assert pair.differs
    assert pair.effect == "large"


def test_the_default_targets_are_quartiles_of_all_scores() -> None:
    found = compare_experiments("millipede-random", "millipede-crossover")
    every = np.sort(np.concatenate([one.final for one in found.samples.values()]))
    step = 10 ** np.floor(np.log10(np.ptp(every)) - 3)
    assert len(found.ert_targets) == 3
    for target, score in zip(found.ert_targets, every[[19, 39, 59]], strict=True):
        assert target <= score < target + 1.001 * step
    assert "quartiles" in to_dict(found)["ert_targets_chosen"]
    assert found.ert_rule in methods(found)


def test_unreached_targets_are_reported_in_one_line() -> None:
    found = compare_experiments("millipede-random", "millipede", targets=(3, 98, 99), repeats=9)
    (note,) = found.notes
    assert "98 or any higher target" in note
    assert note in report(found, "x", [])
    assert all(one.rate == 0 for one in found.reached["millipede"][1:])
    assert [one.p_time for one in found.target_tests[1:]] == [1, 1]
    only = analyse(found.samples, found.evaluations, [99])
    assert Comparison.of(only).plot("ecdf").axes[0].get_ylim() == (0, 102)
    given = to_dict(only)
    assert given["targets_chosen"] == given["ert_targets_chosen"] == "given by the user"


def test_too_few_repeats_and_equal_scores_are_reported() -> None:
    samples = compare_experiments(
        "millipede-random", "millipede", "millipede-mutation", repeats=9
    ).samples
    few = {key: Sample(one.experiment, one.best[:2]) for key, one in samples.items()}
    intervals, tests = analyse(few, 108).notes
    assert "2 repeats are too few for confidence intervals" in intervals
    assert "tests, the smallest possible p after correction is 1." in tests
    assert " – " in report(analyse(few, 108), "x", [])
    equal = {key: Sample(one.experiment, np.full((9, 3), 4.0)) for key, one in samples.items()}
    found = analyse(equal, 108)
    assert all((pair.p, pair.a12, pair.differs) == (1, 0.5, False) for pair in found.pairs)
    assert "the same best score, 4" in found.notes[0]
    assert found.ert_targets == [4]
    assert report(found, "x", [])


def test_the_order_of_experiments_changes_no_result(tmp_path) -> None:
    one, other = tmp_path / "a.toml", tmp_path / "b.toml"
    text = gs.load_experiment("millipede").to_toml()
    one.write_text(text)
    other.write_text(text.replace("generations = ", "# ").replace("pairs = 3", "pairs = 2"))
    more = tmp_path / "c.toml"
    more.write_text(text.replace("population = ", "population = 1"))
    given = [str(one), "millipede", "millipede-random", str(other), "millipede", str(more)]
    budgets = [equal_budgets(load_experiments(way, {}), 5000)[1] for way in (given, given[::-1])]
    forward, backward = ({label: e.to_toml() for label, e in b.items()} for b in budgets)
    assert forward == backward
    seeds = [e.seed for e in budgets[0].values()]
    assert len(set(seeds)) == len(given)
    # A third experiment changes nothing, and the written files reproduce the results.
    assert load_experiments(given[1:3], {})["millipede-random"].seed == seeds[2]
    for label, text in forward.items():
        (tmp_path / f"{label}.toml").write_text(text)
    again = load_experiments([str(tmp_path / f"{label}.toml") for label in forward], {})
    assert {label: e.to_toml() for label, e in again.items()} == forward


def test_experiments_with_different_populations_have_equal_budgets() -> None:
    one, other = load_experiments(["millipede", "millipede-random"], SHORT).values()
    other = with_overrides(other, {"evolution.population": 41})
    sizes = one.individuals, other.individuals
    assert sizes[0] < sizes[1] < 12 * sizes[0]
    budget, short = equal_budgets({"a": one, "b": other}, None)
    assert budget == 12 * sizes[0]  # all of the first experiment
    lengths = [e.evolution.generations for e in short.values()]
    assert lengths == [12, budget // sizes[1]]
    samples = {k: Sample(e, repeat_experiment(e, 5)) for k, e in short.items()}
    found = analyse(samples, budget, ())
    assert budget - sizes[1] < samples["b"].evaluations[-1] <= budget == found.evaluations
    # A generation may use the whole budget, but not more.
    assert equal_budgets({"a": one, "b": other}, sizes[1])[1]["b"].evolution.generations == 1
    with pytest.raises(GaitsimError, match="not enough for one generation of b") as caught:
        equal_budgets({"a": one, "b": other}, sizes[1] - 1)
    assert str(sizes[1]) in caught.value.allowed


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"experiments": "millipede"}, "a comparison needs two experiments"),
        ({"repeats": 1}, "invalid number of repeats: 1"),
        ({"evaluations": 9.5}, "invalid number of evaluations: 9.5"),
        ({"evaluations": 8}, "not enough for one generation"),
        ({"evaluations": 10**12}, "invalid evolution.generations: .*number of generations"),
        ({"targets": [1, float("inf")]}, "invalid target: inf"),
        ({"targets": "high"}, "invalid target: 'high'"),
    ],
)
def test_invalid_arguments_are_reported_before_any_evolution(arguments, says) -> None:
    with pytest.raises(GaitsimError, match=says):
        gs.compare(**{"experiments": ["millipede", "millipede"], "set": SHORT} | arguments)


def test_python_and_the_command_give_the_same_comparison() -> None:
    names = ["millipede-random", "millipede-mutation"]
    found = gs.compare(names, repeats=40, set=SHORT, targets=[3.0])
    same = compare_experiments(*names, targets=(3.0,))
    assert to_dict(found) == to_dict(same)
    assert found.plot("convergence").axes[0].get_xlim() == (0, found.evaluations)
    with pytest.raises(GaitsimError, match="convergence, ecdf"):
        found.plot("surface")


def test_repeats_without_a_score_rank_last() -> None:
    loaded = load_experiments(["millipede", "millipede-random"], SHORT)
    samples = {k: Sample(e, repeat_experiment(e, 8)) for k, e in loaded.items()}
    samples["millipede"].best[:5] = -np.inf
    found = analyse(samples, 108)
    text = report(found, "x", [])
    assert "Every individual failed in 5 of 8 repeats of millipede;" in text
    assert "| millipede | failed | failed to " in text
    assert np.isfinite([*found.ert_targets, *found.targets]).all()
    (pair,) = found.pairs
    assert pair.a12 < 0.4
    values = json.loads(as_json(to_dict(found)))["experiments"]["millipede"]
    assert (values["median"], values["failed"]) == (None, 5)
    assert Comparison.of(found).plot("convergence").axes[0].lines
    samples["millipede"].best[:] = samples["millipede-random"].best[:] = -np.inf
    with pytest.raises(GaitsimError, match="every individual failed in all repeats"):
        analyse(samples, 108)
