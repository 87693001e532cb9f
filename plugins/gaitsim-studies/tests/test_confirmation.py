"""A study claims only what fresh repeats confirm."""

import numpy as np
import pytest
from in_turn import InTurn
from scipy import stats

from gaitsim_studies.confirmation import confirm, search
from gaitsim_studies.file import cells, parse_study
from gaitsim_studies.results import write_results
from gaitsim_studies.running import FRESH, results, run_cells
from gaitsim_studies.statistics import Means

STUDY = """
name = "small"
experiments = ["millipede-mutation"]
set = { "evolution.generations" = 8 }
repeats = 20
confirm = 400
record_every = 2
target = 5.0
[axes]
"evolution.population" = { from = 5, to = 13, step = 2 }
"""
SPREAD = 1.0
CELLS = cells(parse_study(STUDY, "small.toml"))
DRAWN = np.random.default_rng(7)


@pytest.fixture
def study():
    return parse_study(STUDY, "small.toml")


def means(true, repeats):
    """Return the means of repeats whose scores are drawn around true means, (generations,)."""
    error = np.full(len(true), SPREAD / np.sqrt(repeats))
    return Means(repeats, DRAWN.normal(true, error), error, np.zeros(len(true)))


def true_means(cell):
    """Return means that grow with population and generations, (generations,)."""
    generations = np.arange(2, cell.experiment.evolution.generations + 1, 2)
    return 5 + (generations * cell.experiment.evolution.population - 60) / 60


def run_search(study, true, sweep=None, failing=0):
    """Return the result of a search, and the cells that it requested in each round.

    The first `failing` tests get means far below the target.
    """
    every = [(cell, sweep or means(true(cell), 20)) for cell in CELLS]
    going, rounds, seeds, answer = search(study, study.target, every), [], {}, None
    while True:
        try:
            rounds.append(going.send(answer))
        except StopIteration as stop:
            return stop.value, rounds
        answer = []
        for cell in rounds[-1]:
            known = seeds.setdefault(cell.index, [])
            known += [cell.experiment.seed] * (cell.experiment.seed not in known)
            test = known.index(cell.experiment.seed) == 1
            lower, failing = (99, failing - 1) if test and failing else (0, failing)
            answer.append(means(true(cell) - lower, study.fresh.repeats))


def test_intervals_without_skew_are_students_and_allow_for_failures():
    half = np.random.default_rng(0).normal(size=(9, 4))
    scores = np.concatenate([half, -half])  # no skew
    scores[2, 1] = -np.inf
    scores[:, 2] = 1.7e308
    scores[:, 3] = 3.0
    found = Means.of(scores)
    low, high = found.interval(0.99)
    expected = stats.t.interval(0.99, 17, scores[:, 0].mean(), stats.sem(scores[:, 0]))
    np.testing.assert_allclose((low[0], high[0]), expected)
    assert (low[1], high[1]) == (-np.inf, -np.inf)
    assert (low[2], high[2]) == (-np.inf, np.inf)
    assert (low[3], high[3]) == (3.0, 3.0)
    assert Means.of(scores[:1]).interval(0.95)[0][0] == -np.inf


@pytest.mark.slow
def test_false_candidates_of_a_sweep_are_rarely_confirmed(study):
    wrong = reached = 0
    for _ in range(100):
        found, _ = run_search(study, lambda cell: np.full(len(true_means(cell)), 5 - 1e-9))
        wrong += found.reached
        found, _ = run_search(study, true_means)
        reached += found.reached and found.population * found.generations >= 60
    assert wrong < 8  # 2.5 % of 100, and three standard deviations
    assert reached > 90


def test_cells_that_cost_more_than_a_clear_candidate_are_not_repeated(study):
    found, rounds = run_search(study, lambda cell: 100 * (true_means(cell) - 5) + 4.9)
    cost = found.population * found.generations
    assert found.reached
    assert cost == 66  # 11 × 6; 60 is missed by 0.1
    evolutions = [cell.experiment.evolution for cells in rounds for cell in cells]
    assert all(one.population * one.generations <= cost for one in evolutions)


def test_after_a_failed_test_the_next_candidate_has_half_the_error(study):
    usual, _ = run_search(study, lambda cell: 100 * (true_means(cell) - 5) + 4.9)
    later, _ = run_search(study, lambda cell: 100 * (true_means(cell) - 5) + 4.9, failing=1)
    assert (usual.level, usual.reached, later.reached) == (0.975, True, True)
    # One set covers all generations of the failing row, so several tests may fail.
    assert 1 - later.level in [pytest.approx(0.025 / 2**k) for k in range(1, 4)]
    cost, more = (one.population * one.generations for one in (usual, later))
    assert more > cost


@pytest.mark.parametrize("target", [9.0, 1e300])
def test_an_unreached_target_reports_the_highest_mean(study, target):
    changed = study.model_copy(update={"target": target})
    found, rounds = run_search(changed, true_means)
    assert not found.reached
    assert (found.population >= 9, found.repeats) == (True, 400)
    assert found.low < true_means(rounds[-1][0])[-1] < found.high


def test_cells_whose_repeats_all_fail_are_not_tested(study):
    failed = Means.of(np.full((20, 4), -np.inf))
    found, rounds = run_search(study, true_means, sweep=failed)
    assert (found.reached, found.mean, found.repeats, rounds) == (False, -np.inf, 0, [])


def test_a_stopped_confirmation_resumes_to_the_same_result(study, tmp_path):
    few = study.model_copy(update={"confirm": 100})
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for folder in (whole, cut):
        folder.mkdir()
    list(run_cells(cut, few, CELLS, 1, cluster=InTurn()))
    found = results(cut, few, CELLS)[0]
    first, again = [], []
    once = confirm(whole, few, found, 1, on_sets=lambda *of: first.append(of), cluster=InTurn())

    def stop(done, total):
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        confirm(cut, few, found, 1, on_sets=stop, cluster=InTurn())
    assert len([*(cut / FRESH).iterdir()]) == 1
    continued = confirm(cut, few, found, 1, on_sets=lambda *of: again.append(of), cluster=InTurn())
    assert continued == once
    assert again[0][0] == 1
    assert again[-1] == first[-1]
    write_results(cut, few, found, once)
    assert f"| {once[0].mean:.3f} (" in (cut / "report.md").read_text()
    fresh = [np.load(path)[:20, 0] for path in (cut / FRESH).iterdir()]
    swept = [best[:, 0] for _, best in found]
    assert not any(np.array_equal(one, other) for one in fresh for other in swept)


def test_without_a_target_there_are_no_fresh_repeats(study, tmp_path):
    assert confirm(tmp_path, study.model_copy(update={"target": None}), [], 1) == []
    assert not [*tmp_path.iterdir()]
