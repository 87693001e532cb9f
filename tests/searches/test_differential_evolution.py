"""Differential evolution: the paper's formulas, optima, saved states and invalid states."""

from itertools import islice, takewhile

import numpy as np
import pytest
from scipy import stats
from searching import box, generations

from gaitsim.contracts.search import Context, Results
from gaitsim_searches.differential_evolution import DifferentialEvolution, draw_scales
from gaitsim_searches.real import differences, halved_past_bounds

SEARCH = DifferentialEvolution()


def sphere(genomes):
    return -np.sum((genomes - 1) ** 2, axis=1)


def rosenbrock(genomes):
    steps = 100 * (genomes[:, 1:] - genomes[:, :-1] ** 2) ** 2 + (1 - genomes[:, :-1]) ** 2
    return -steps.sum(axis=1)


def rastrigin(genomes):
    waves = genomes**2 - 10 * np.cos(2 * np.pi * genomes) + 10
    return -waves.sum(axis=1)


def context(genes=3, population=6, rng=0, **parts):
    return Context(box(genes), population, 1, np.random.default_rng(rng), **parts)


# Each budget is 1.3 times the median of 21 seeds, and exceeds the largest of them.
@pytest.mark.parametrize(
    ("score", "genes", "population", "budget"),
    [(sphere, 10, 30, 5_000), (rosenbrock, 5, 30, 6_500), (rastrigin, 5, 50, 15_000)],
    ids=["sphere", "rosenbrock", "rastrigin"],
)
def test_the_optimum_is_found(score, genes, population, budget):
    found = generations(SEARCH, box(genes), score, population)
    missed = takewhile(lambda each: each[1].scores.max() < -1e-8, islice(found, 1_000))
    assert population * (1 + sum(1 for _ in missed)) < budget


def test_the_memory_stores_weighted_means_of_successful_trials():
    # Gains of 1 and 3 have weights of 1/4 and 3/4.
    # F: (0.04/4 + 3 × 0.36/4) / (0.2/4 + 3 × 0.6/4) = 0.56; CR of SHADE: 0.1/4 + 3 × 0.5/4 = 0.4.
    # The third trial does not improve on its target, so it is ignored.
    genomes = context().random(4)
    state = {
        **SEARCH.initial(context()),
        "genomes": genomes,
        "scores": np.array([0.0, 0.0, 5.0, 5.0]),
        "trial F": np.array([0.2, 0.6, 1.0, 1.0]),
        "trial CR": np.array([0.1, 0.5, 1.0, 1.0]),
    }
    trials = Results(genomes + 0.5, np.array([1.0, 3.0, 5.0, 4.0]))
    after = SEARCH.tell(state, trials, context(population=4))

    np.testing.assert_allclose(after["memory F"], [0.56, 0.5, 0.5, 0.5, 0.5, 0.5])
    np.testing.assert_allclose(after["memory CR"], [0.4, 0.9, 0.9, 0.9, 0.9, 0.9])
    assert after["next"] == 1
    # Equal trials replace their genomes, but only genomes with lower scores are archived.
    np.testing.assert_array_equal(after["genomes"][:3], trials.genomes[:3])
    np.testing.assert_array_equal(after["genomes"][3], genomes[3])
    np.testing.assert_array_equal(after["archive"], genomes[:2])
    assert SEARCH.figures(after)["mean F"] == pytest.approx(0.51)

    nothing = SEARCH.tell(after, Results(genomes, np.full(4, -np.inf)), context(population=4))
    for name in ("memory F", "memory CR", "next", "genomes", "archive"):
        np.testing.assert_array_equal(nothing[name], after[name])


def test_the_oldest_memory_is_replaced_and_the_archive_keeps_its_size():
    search = DifferentialEvolution(memory=2, archive=0.5)
    states = [state for state, _ in islice(generations(search, box(3), sphere, 8), 30)]

    assert {int(state["next"]) for state in states} == {0, 1}
    assert max(len(state["archive"]) for state in states) == 4
    assert len(states[-1]["memory F"]) == 2


def test_scale_factors_are_cauchy_distributed_above_0_and_clipped_at_1():
    drawn = draw_scales(np.full(20_000, 0.1), np.random.default_rng(1))
    assert (drawn > 0).all()
    assert drawn.max() == 1
    cauchy = stats.cauchy(0.1, 0.1)
    assert (drawn == 1).mean() == pytest.approx(cauchy.sf(1) / cauchy.sf(0), abs=0.005)
    below = np.linspace(0, 0.99, 50)
    share = [(drawn <= x).mean() for x in below]
    np.testing.assert_allclose(
        share, (cauchy.cdf(below) - cauchy.cdf(0)) / cauchy.sf(0), atol=0.012
    )


def test_a_trial_moves_towards_one_of_the_best_and_along_a_difference_of_others():
    # With CR = 1 and known F, each trial must be one of a few possible sums.
    search = DifferentialEvolution(greediness=0.01)
    genomes = context().random(6) / 5
    state = {
        **search.initial(context()),
        "genomes": genomes,
        "scores": np.arange(6.0),
        "archive": np.full((1, 3), 0.25),
        "memory CR": np.full(6, 5.0),
    }
    others = np.concatenate([genomes, state["archive"]])
    for seed in range(20):
        trials, asked = search.ask(state, None, context(rng=seed))
        for number, (trial, scale) in enumerate(zip(trials, asked["trial F"], strict=True)):
            possible = [
                genomes[number] + scale * (genomes[best] - genomes[number] + genomes[one] - other)
                for best in (4, 5)
                for one in range(6)
                for position, other in enumerate(others)
                if len({number, one, position}) == 3
            ]
            assert np.isclose(trial, possible, atol=1e-12).all(axis=1).any()


def test_genomes_approach_a_bound_without_crossing_it():
    space = box(4, -1, 3)
    found = list(islice(generations(SEARCH, space, lambda genomes: genomes.sum(axis=1), 12), 80))

    assert all(space.contains(results.genomes) for _, results in found)
    assert max(results.scores.max() for _, results in found) > 11.99


def test_genes_past_a_bound_move_halfway_to_it_and_periodic_genes_wrap():
    space = box(3, 0, 4, periodic=np.array([False, False, True]))
    start, moved = np.array([[1.0, 2.0, 3.5]]), np.array([[-2.0, 9.0, 4.5]])

    np.testing.assert_allclose(halved_past_bounds(moved, start, space), [[0.5, 3.0, 0.5]])
    to = np.array([[3.5, 0.5, 0.5]])
    np.testing.assert_allclose(differences(to, start, space), [[2.5, -1.5, 1.0]])


def test_periodic_genes_cross_their_bounds():
    space = box(4, 0, 2 * np.pi, periodic=np.ones(4, bool))
    start = np.full(4, 5.5)  # 1.1 from the optimum across the bound, 5.2 otherwise

    def score(genomes):
        return np.cos(genomes - 0.3).sum(axis=1)

    found = list(islice(generations(SEARCH, space, score, 12, start=start), 80))
    genomes = np.concatenate([results.genomes for _, results in found])

    assert space.contains(genomes)
    assert found[-1][1].scores.max() > 3.999
    assert not ((genomes > 2) & (genomes < 3.6)).all(axis=1).any()


def test_a_quarter_of_the_first_genomes_is_a_start_point_and_genomes_around_it():
    start = np.array([4.0, -4.9, 0.5])
    context_of_start = context(population=4_000, starts=start[None])
    genomes, _ = SEARCH.ask(SEARCH.initial(context()), None, context_of_start)

    np.testing.assert_array_equal(genomes[0], start)
    assert box(3).contains(genomes)
    assert genomes[1_000:, 2].std() == pytest.approx(10 / np.sqrt(12), rel=0.05)
    genomes = genomes[:1_000]
    assert genomes[:, 2].std() == pytest.approx(SEARCH.spread * 10, rel=0.05)
    assert np.median(genomes, axis=0) == pytest.approx(start, abs=0.1)


def test_failed_individuals_never_replace_others():
    def half(genomes):
        return np.where(genomes[:, 0] > 0, sphere(genomes), -np.inf)

    found = list(islice(generations(SEARCH, box(3), half, 12), 120))
    assert max(results.scores.max() for _, results in found) > -1e-6

    failing = generations(SEARCH, box(3), lambda genomes: np.full(len(genomes), -np.inf), 10)
    state = [state for state, _ in islice(failing, 10)][-1]
    assert state["restarts"] >= 1
    assert all(np.isfinite(array).all() for name, array in state.items() if name != "scores")


def test_without_restarts_convergence_ends_the_run():
    search = DifferentialEvolution(restarts=False)
    states = [state for state, _ in islice(generations(search, box(2), sphere, 12), 400)]
    ends = [bool(search.finished(state)) for state in states]
    first = ends.index(True)
    assert first > 20
    assert "all scores are equal" in search.finished(states[first])
    assert SEARCH.finished(states[first]) == ""
    scores = np.arange(12.0)
    again = search.rescored(states[first], Results(states[first]["genomes"], scores), context())
    assert search.finished(again) == ""


def test_rescored_states_and_mismatches():
    first = SEARCH.initial(context())
    assert SEARCH.remembered(first) is None
    assert SEARCH.mismatch(first, context()) == ""
    *_, (state, _) = islice(generations(SEARCH, box(3), sphere, 6), 5)

    remembered = SEARCH.remembered(state)
    assert remembered is not None
    rescored = SEARCH.rescored(state, Results(remembered, np.arange(6.0)), context())
    np.testing.assert_array_equal(rescored["scores"], np.arange(6.0))
    np.testing.assert_array_equal(rescored["archive"], state["archive"])

    assert SEARCH.mismatch(state, context()) == ""
    assert "genes" in SEARCH.mismatch(state, context(genes=4))
    assert "the population is 7" in SEARCH.mismatch(state, context(population=7))
    assert "memory" in DifferentialEvolution(memory=7).mismatch(state, context())
    assert "at least 4" in SEARCH.objection(box(3), 3)
    assert SEARCH.objection(box(3), 4) == ""
