"""CMA-ES: constants, evaluations to reach targets, invariances and saved states."""

from dataclasses import replace
from itertools import islice, takewhile

import numpy as np
import pytest
from scipy.special import gamma
from scipy.stats import ortho_group
from searching import box, generations, saved

from gaitsim.contracts.search import Context, Results
from gaitsim_searches import cma_es as fold
from gaitsim_searches.cma_es import CmaEs, rates

GENES = 10
FULL, SEPARABLE = CmaEs(), CmaEs(covariance="separable")
BIPOP = CmaEs(restarts="bipop", tolerance=1e-3)


def sphere(genomes):
    return -np.sum((genomes - 1) ** 2, axis=1)


def ellipsoid(genomes, axes=None):
    """Return an ellipsoid of condition 10⁶, rotated if `axes`, (genes, genes), is given."""
    turned = genomes - 1 if axes is None else (genomes - 1) @ axes
    return -np.sum(np.logspace(0, 6, turned.shape[1]) * turned**2, axis=1)


def evaluations(search, score, *, target=-1e-9, population=10, genes=GENES):
    """Return the number of evaluations until a genome reaches the target."""
    found = generations(search, box(genes), score, population)
    missed = takewhile(lambda each: each[1].scores.max() < target, islice(found, 2_000))
    return population * (1 + sum(1 for _ in missed))


def test_constants_are_those_that_pycma_documents_for_20_genes_and_12_samples():
    found = rates(20, 12, separable=False, active=True)

    best = [0.4024029428, 0.2533890840, 0.1662215645, 0.1043752252, 0.05640347757, 0.01720770576]
    worse = [-0.05018713636, -0.1406167894, -0.2203813963, -0.2917332686]
    np.testing.assert_allclose(found.weights[:10], best + worse, rtol=1e-8)
    assert found.rank_one == pytest.approx(0.00437235, rel=1e-5)
    assert found.rank_mu == pytest.approx(0.00921656, rel=1e-5)
    assert found.path == pytest.approx(0.171767, rel=1e-5)
    assert found.length == pytest.approx(np.sqrt(2) * gamma(10.5) / gamma(10), rel=1e-4)


def test_negative_weights_keep_the_covariance_in_balance():
    for genes, samples in ((2, 6), (20, 12), (48, 100)):
        found = rates(genes, samples, separable=False, active=True)
        positive = found.weights[: found.parents].sum()
        negative = -found.weights[found.parents :].sum()

        assert positive == pytest.approx(1)
        assert 0 < negative <= (1 + found.rank_one / found.rank_mu) * (1 + 1e-12)
        assert genes * found.rank_mu * negative <= (1 - found.rank_one - found.rank_mu) * (
            1 + 1e-12
        )


def test_a_sphere_takes_about_1_500_evaluations():
    assert evaluations(FULL, sphere) < 2_000
    assert evaluations(SEPARABLE, sphere) < 2_000


def test_the_full_covariance_learns_a_rotated_ellipsoid():
    rotation = ortho_group.rvs(GENES, random_state=0)

    assert evaluations(FULL, lambda genomes: ellipsoid(genomes, rotation)) < 6_500


def test_the_separable_covariance_learns_an_axis_parallel_ellipsoid_faster():
    assert evaluations(SEPARABLE, ellipsoid) < 4_000 < evaluations(FULL, ellipsoid)


@pytest.mark.parametrize("search", [FULL, SEPARABLE], ids=["full", "separable"])
def test_only_the_order_of_the_scores_matters(search):
    plain = generations(search, box(GENES), sphere, 10)
    bent = generations(search, box(GENES), lambda genomes: -np.exp(-sphere(genomes) / 50), 10)

    for (_, first), (_, second) in islice(zip(plain, bent, strict=True), 50):
        assert (first.genomes == second.genomes).all()


@pytest.mark.parametrize("search", [FULL, SEPARABLE, BIPOP], ids=["full", "separable", "bipop"])
def test_a_saved_state_continues_bit_for_bit(search):
    whole = list(islice(generations(search, box(2), sphere, 6), 150))
    restarted = [int(state["restarts"]) for state, _ in whole]
    first, last = restarted.index(1), restarted.index(restarted[-1])
    # After a restart, an update takes two or more generations: save between them, too.
    assert any(len(state["scores"]) for state, _ in whole[first : first + 2])
    limited = [index for index, (state, _) in enumerate(whole) if state["limit"]][:2]
    assert len(limited) == 2 * (search is BIPOP)
    for stopped in (1, first, first + 1, first + 2, first + 3, last + 1, *limited):
        state, last = whole[stopped - 1]
        rest = generations(search, box(2), sphere, 6, after=(stopped, saved(state), last))

        for (there, results), (here, expected) in zip(rest, whole[stopped:], strict=False):
            assert (results.genomes == expected.genomes).all()
            assert there.keys() == here.keys()
            assert all(np.array_equal(there[name], here[name]) for name in here)


def test_genomes_stay_within_the_bounds_even_if_the_optimum_is_outside():
    space = box(5, -1, 3)
    for _, results in islice(generations(FULL, space, lambda genomes: genomes.sum(axis=1), 8), 60):
        assert space.contains(results.genomes)

    assert results.scores.max() > 14.99


def test_periodic_genes_cross_their_bounds():
    space = box(4, 0, 2 * np.pi, periodic=np.ones(4, bool))
    start = np.full(4, 5.5)  # 1.1 from the optimum across the bound, 5.2 otherwise

    def score(genomes):
        return np.cos(genomes - 0.3).sum(axis=1)

    found = list(islice(generations(FULL, space, score, 8, start=start), 60))
    genomes = np.concatenate([results.genomes for _, results in found])

    assert space.contains(genomes)
    assert found[-1][1].scores.max() > 3.99
    assert not ((genomes > 1.5) & (genomes < 4)).all(axis=1).any()


def test_the_fold_is_smooth_and_reaches_both_bounds():
    space = box(1, 0, 1)
    points = np.linspace(-2, 3, 50_001)[:, None]
    genomes = fold.genomes(points, space)

    assert genomes.min() == pytest.approx(0, abs=1e-9)
    assert genomes.max() == pytest.approx(1, abs=1e-9)
    assert np.abs(np.diff(genomes, 2, axis=0)).max() < 1e-6
    inside = (points > fold.MARGIN) & (points < 1 - fold.MARGIN)
    np.testing.assert_allclose(genomes[inside], points[inside], atol=1e-12)
    for genome in ([0.0], [0.01], [0.4], [0.99], [1.0]):
        there = fold.point(np.array(genome), space)
        np.testing.assert_allclose(fold.genomes(there[None], space)[0], genome, atol=1e-12)


def test_a_warm_start_is_the_mean_of_the_first_samples():
    space, start = box(3), np.array([4.0, -4.0, 0.5])
    _, results = next(generations(CmaEs(start_step=1e-3), space, sphere, 50, start=start))

    np.testing.assert_allclose(results.genomes.mean(axis=0), start, atol=0.01)


def test_failed_individuals_rank_last_and_a_generation_of_failures_restarts():
    def half(genomes):
        return np.where(genomes[:, 0] > 0, sphere(genomes), -np.inf)

    found = list(islice(generations(FULL, box(3), half, 10), 120))
    assert max(results.scores.max() for _, results in found) > -1e-6

    failing = generations(FULL, box(3), lambda genomes: np.full(len(genomes), -np.inf), 10)
    state = [state for state, _ in islice(failing, 40)][-1]
    assert state["restarts"] >= 1
    assert all(np.isfinite(array).all() for name, array in state.items() if "scores" not in name)


def test_larger_tolerances_restart_sooner():
    def restarts(search):
        found = islice(generations(search, box(2), sphere, 6), 60)
        return [int(state["restarts"]) for state, _ in found][-1]

    assert restarts(CmaEs(tolerance=1e-2)) > restarts(FULL) == 0
    assert restarts(CmaEs(score_tolerance=1e-2)) > 0


def test_restarts_take_the_start_points_in_turn():
    starts, search = np.array([[1.0, 2.0], [-3.0, -3.0]]), CmaEs(score_tolerance=1e9, step=0.01)
    state = search.initial(replace(_context(2), starts=starts))
    means, restarts = [state["mean"]], 0
    while len(means) < 4:
        genomes, state = search.ask(state, None, _context(2))
        state = search.tell(state, Results(genomes, sphere(genomes)), _context(2))
        if state["restarts"] > restarts:
            restarts += 1
            means.append(state["mean"])
    expected = [fold.point(start, box(2)) for start in [*starts, *starts]]
    np.testing.assert_array_equal(means, expected)


@pytest.mark.slow
def test_bipop_spends_as_many_evaluations_on_small_runs_as_on_large_ones():
    found = list(islice(generations(BIPOP, box(2), sphere, 6), 2_000))
    runs = {int(state["restarts"]): state for state, _ in reversed(found)}  # the first of each
    last = found[-1][0]
    small, large = int(last["small evaluations"]), int(last["large evaluations"])
    assert last["doublings"] >= 3
    assert small + large + last["evaluations"] == 2_000 * 6
    assert 0.4 < small / (small + large) < 0.6

    for state in runs.values():
        if state["limit"]:
            assert state["limit"] == state["large evaluations"] // 2
            assert 6 <= state["samples"] <= 6 * 2 ** state["doublings"] / 2
            assert 0.2 * 10**-2 <= state["step"] <= 0.2
        else:
            assert state["samples"] == 6 * 2 ** state["doublings"]
    sizes = {int(state["samples"]) for state in runs.values() if state["limit"]}
    steps = [float(state["step"]) for state in runs.values() if state["limit"]]
    assert len(sizes) > 1
    assert len(steps) > 10
    assert np.mean(np.log10(steps)) == pytest.approx(np.log10(0.2) - 1, abs=0.4)


def test_without_restarts_convergence_ends_the_run_or_not():
    stopping, continuing = CmaEs(restarts="stop"), CmaEs(restarts="none")
    states = [state for state, _ in islice(generations(stopping, box(2), sphere, 6), 250)]
    reasons = [stopping.finished(state) for state in states]
    first = next(index for index, reason in enumerate(reasons) if reason)
    assert first > 50
    assert "deviations" in reasons[first] or "range" in reasons[first]
    assert not any(continuing.finished(state) for state in states)
    assert not any(state["restarts"] for state in states)
    # Equal scores are not a reason once the scores are new.
    again = stopping.rescored(states[first], Results(np.empty((0, 2)), np.empty(0)), _context(2))
    assert stopping.finished(again) == ""


def test_scores_of_a_new_stage_do_not_restart():
    """The new fitness is lower by a constant, which changes no rank."""
    found = generations(FULL, box(GENES), ellipsoid, 10)
    state, last = next(islice(found, 199, None))
    whole = [state for state, _ in islice(found, 60)]
    assert FULL.remembered(state) is None

    none = Results(last.genomes[:0], np.empty(0))
    state = FULL.rescored(state, none, _context(GENES))
    last = Results(last.genomes, last.scores - 1e3)
    rest = generations(
        FULL, box(GENES), lambda genomes: ellipsoid(genomes) - 1e3, 10, after=(200, state, last)
    )
    for (now, _), expected in zip(rest, whole, strict=False):
        assert now["restarts"] == 0
        np.testing.assert_array_equal(now["mean"], expected["mean"])


def test_samples_that_wait_for_an_update_are_rescored():
    found = generations(FULL, box(2), sphere, 6)
    state, last = next(
        (state, last) for state, last in found if state["restarts"] and len(state["scores"])
    )
    waiting = FULL.remembered(state)
    assert waiting is not None
    np.testing.assert_array_equal(waiting, last.genomes)
    np.testing.assert_array_equal(sphere(waiting), state["scores"])

    after = FULL.rescored(state, Results(waiting, sphere(waiting) / 2), _context(2))
    np.testing.assert_array_equal(after["scores"], state["scores"] / 2)
    assert len(after["steps"]) == 6


def test_figures_and_mismatches():
    state = FULL.initial(_context(3))

    figures = {"step size": pytest.approx(0.2), "condition number": 1, "restarts": 0}
    assert FULL.figures(state) == figures
    assert FULL.mismatch(state, _context(3)) == ""
    assert "separable" in SEPARABLE.mismatch(state, _context(3))
    assert "genes" in FULL.mismatch(state, _context(4))
    assert "at least 4" in FULL.objection(box(3), 3)


def _context(genes):
    return Context(box(genes), 10, 1, np.random.default_rng(0))
