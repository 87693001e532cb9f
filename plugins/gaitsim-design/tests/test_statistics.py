"""Noise, intervals, plateaus and response surfaces, beside SciPy and closed forms."""

import numpy as np
import pytest
from scipy import stats

from gaitsim_design.statistics import (
    ResponseSurface,
    SearchNoise,
    differences,
    intervals,
    plateau,
    shares,
)


def values(designs, replicates, spread=1.0, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(0, spread, (designs, replicates)) + rng.normal(0, 5, replicates)


def test_intervals_are_students():
    found = values(4, 5)
    means, half = intervals(found)
    low, high = stats.t.interval(0.95, 4, found.mean(axis=1), stats.sem(found, axis=1))
    np.testing.assert_allclose([means - half, means + half], [low, high])
    assert np.isnan(intervals(found[:, :1])[1]).all()


def test_for_two_designs_the_test_is_the_paired_t_test():
    found = values(2, 6)
    found[1] += 0.7
    noise = SearchNoise.of(found)
    assert noise.freedom == 5
    p_value = noise.p_values(found.mean(axis=1))[0, 1]
    assert p_value == pytest.approx(stats.ttest_rel(found[1], found[0]).pvalue)


def test_equal_designs_share_their_noise_and_unequal_ones_keep_their_own():
    found = values(40, 3, spread=0.3)
    moved = found + 100 * np.arange(40)[:, None]
    noise = SearchNoise.of(moved)
    np.testing.assert_allclose(noise.deviations, SearchNoise.of(found).deviations)
    assert np.ptp(noise.deviations) < 0.5 * np.ptp(found.std(axis=1, ddof=1))
    assert noise.deviations.mean() == pytest.approx(0.3, rel=0.25)
    with_failure = SearchNoise.of(np.vstack([found, np.full((1, 3), np.nan)]))
    np.testing.assert_allclose(with_failure.deviations[:-1], noise.deviations)
    assert np.isnan(with_failure.deviations[-1])
    rng = np.random.default_rng(0)
    spreads = np.exp(rng.normal(0, 1.5, (200, 1)))
    noise = SearchNoise.of(rng.normal(0, spreads, (200, 3)))
    assert stats.spearmanr(noise.deviations, spreads[:, 0]).statistic > 0.6
    assert 2 < noise.freedom < 6


def test_differences_and_plateau_need_more_than_the_noise():
    found = values(20, 3, spread=0.01)
    found[3] += 1
    found[5] -= 1
    found[7] = np.nan
    changed = differences(found, 0)
    assert changed[3] == 1
    assert changed[5] == -1
    assert np.abs(changed).sum() == 2
    assert np.flatnonzero(plateau(found)).tolist() == [3]
    found[3] -= 1
    assert 16 <= plateau(found).sum() <= 18
    assert not plateau(found)[[5, 7]].any()
    # One replicate shows no noise: nothing differs, and only the best is on the plateau.
    assert not differences(found[:, :1], 0).any()
    assert plateau(found[:, :1]).sum() == 1


@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_few_maps_without_differences_show_any(spread):
    rng = np.random.default_rng(1)
    wrong = np.zeros(2)
    for _ in range(300):
        own = np.exp(rng.normal(0, spread, (30, 1)))
        found = rng.normal(0, own, (30, 3))
        wrong += bool(differences(found, 0).any()), not plateau(found).all()
    assert (wrong / 300 < 0.08).all()


def test_shares_are_the_sobol_indices_of_a_quadratic_function():
    axis = np.linspace(-1, 1, 7)
    points = np.stack(np.meshgrid(axis, axis, indexing="ij"), -1).reshape(-1, 2)
    x, y = points.T
    share, ends, r_squared = shares(points, (3 * x + 2 * y**2 + x * y)[:, None].repeat(2, axis=1))
    # Variances of uniform x and y in −1 to 1: 3x has 9/3, 2y² has 4 (1/5 − 1/9), xy has 1/9.
    parts = np.array([3, 4 * (1 / 5 - 1 / 9), 1 / 9])
    np.testing.assert_allclose(share, parts[:2] / parts.sum())
    np.testing.assert_allclose(ends, [share, share])
    assert r_squared == pytest.approx(1)


def test_r_squared_is_that_of_least_squares_and_effects_are_means():
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (200, 1))
    found = 2 * points[:, 0] + rng.normal(0, 1, 200)
    found[0] = np.nan
    surface = ResponseSurface.fit(points, found)
    coefficients = np.polyfit(points[1:, 0], found[1:], 2)
    rest = found[1:] - np.polyval(coefficients, points[1:, 0])
    assert surface.r_squared == pytest.approx(1 - rest.var() / found[1:].var())
    at = np.array([-1.0, 0.3])
    np.testing.assert_allclose(surface.effect(0, at), np.polyval(coefficients, at))


@pytest.mark.parametrize("count", [3, 6])
def test_too_few_or_equal_designs_have_no_surface(count):
    points = np.random.default_rng(0).uniform(-1, 1, (count, 2))
    assert np.isnan(shares(points, values(count, 2))[0]).all()
    assert ResponseSurface.fit(np.linspace(-1, 1, 9)[:, None], np.ones(9)) is None
