import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from gaitsim_studies.statistics import (
    LEAST,
    describe,
    effect_interval,
    effect_name,
    holm,
    least_p,
    mean_interval,
    median_interval,
    quantiles,
    rank_test,
    rate_interval,
)


def test_description_of_a_known_sample() -> None:
    found = describe([1, 2, 3, 4, 5, 100])
    assert (found.n, found.median, found.q25, found.q75) == (6, 3.5, 2.25, 4.75)
    assert (found.minimum, found.maximum, found.mean) == (1, 100, pytest.approx(115 / 6))
    assert found.std == pytest.approx(np.std([1, 2, 3, 4, 5, 100], ddof=1))
    assert (found.median_low, found.median_high) == (1, 100)
    assert describe([2.0] * 7).median_low == describe([2.0] * 7).median_high == 2


def test_a_repeat_without_a_score_ranks_last() -> None:
    found = describe([-np.inf, 3, -np.inf, -np.inf, 1, 2, 5, 4])
    assert (found.failed, found.minimum, found.q25, found.median) == (3, -np.inf, -np.inf, 1.5)
    assert (found.median_low, found.median_high) == (-np.inf, 5)
    assert quantiles([[-np.inf, 1], [-np.inf, 2]], [0.5]).tolist() == [[-np.inf, 1.5]]
    failed, lowest = np.array([-np.inf, 2.0, 3.0]), np.array([-9.0, 2.0, 3.0])
    assert rank_test(failed, [1.0, 4.0]) == rank_test(lowest, [1.0, 4.0])


@pytest.mark.parametrize("n", [LEAST - 1, LEAST, 7, 10, 30, 101])
def test_the_interval_of_a_median_agrees_with_scipy(n: int) -> None:
    values = np.random.default_rng(n).exponential(1.0, n)
    found = median_interval(values)
    expected = stats.quantile_test(values, q=0, p=0.5).confidence_interval(0.95)
    assert found == pytest.approx(tuple(expected), nan_ok=True)
    assert np.isnan(found[0]) == (n < LEAST)


def test_the_interval_of_a_success_rate_agrees_with_published_numbers() -> None:
    """Newcombe (1998, "Two-sided confidence intervals for the single proportion"), table I."""
    assert rate_interval(81, 263) == pytest.approx((0.2527, 0.3676), abs=5e-5)
    assert rate_interval(15, 148) == pytest.approx((0.0578, 0.1617), abs=5e-5)
    assert rate_interval(0, 20) == pytest.approx((0, 0.1684), abs=5e-5)
    assert rate_interval(1, 29) == pytest.approx((0.0009, 0.1776), abs=5e-5)


def test_the_interval_of_a_mean_without_skewness_is_that_of_student() -> None:
    values = np.tile([1.0, 2, 4, 6, 7, 4], 4)
    expected = stats.ttest_1samp(values, 0).confidence_interval(0.95)
    assert mean_interval(values) == pytest.approx(tuple(expected))
    assert np.isnan(mean_interval(values[:19])).all()
    assert np.isnan(mean_interval([3.0] * 29)).all()


def test_the_interval_of_the_effect_of_disjoint_samples() -> None:
    """Its end differs from 1 by 1.96 standard errors of Newcombe's equation at this end."""
    for n, m in ((6, 6), (30, 20)):
        low, high = effect_interval(np.arange(n) + 100, np.arange(m))
        assert high == 1
        spread = 1 + ((n + m) / 2 - 1) * ((1 - low) / (2 - low) + low / (1 + low))
        error = np.sqrt(low * (1 - low) * spread / (n * m))
        assert 1 - low == pytest.approx(stats.norm.ppf(0.975) * error)
        assert effect_interval(np.arange(m), np.arange(n) + 100) == pytest.approx((0, 1 - low))


@pytest.mark.slow
@pytest.mark.parametrize("n", [6, 10, 30])
def test_intervals_have_their_confidence_level(n: int) -> None:
    """Scores with two modes, and a second sample between them."""
    rng, sets = np.random.default_rng(1), 400
    covered = np.zeros(2)
    for _ in range(sets):
        low = rng.random(n) < 0.4
        scores = np.where(low, rng.normal(2.2, 0.05, n), rng.normal(2.6, 0.03, n))
        ends = np.array(
            [
                median_interval(scores),
                effect_interval(scores, rng.normal(2.4, 0.01, n)),
            ]
        )
        # The median leaves 1/6 of the upper mode below it.
        truth = 2.6 + 0.03 * stats.norm.ppf(1 / 6), 0.6
        covered += (ends[:, 0] <= truth) & (truth <= ends[:, 1])
    assert (covered >= 0.92 * sets).all()


@settings(max_examples=25)
@given(st.lists(st.integers(0, 4), min_size=4, max_size=9), st.integers(2, 3))
def test_the_rank_test_is_exact_with_ties(values: list[int], n: int) -> None:
    """The p-value is twice the share of assignments whose rank sum is at least as extreme."""
    ranks = stats.rankdata(values)
    sums = [sum(ranks[i] for i in chosen)
            for chosen in itertools.combinations(range(len(values)), n)]  # fmt: skip
    tails = [np.mean(np.array(sums) >= sums[0]), np.mean(np.array(sums) <= sums[0])]
    p, a12 = rank_test(values[:n], values[n:])
    assert p == pytest.approx(min(1, 2 * min(tails)))
    assert rank_test(values[n:], values[:n]) == (p, pytest.approx(1 - a12))


def test_the_smallest_p_belongs_to_disjoint_samples() -> None:
    for n in (1, 2, 3, 6):
        p, _ = rank_test(range(n), range(n, 2 * n))
        assert least_p(n, 1) == pytest.approx(p)
        assert stats.fisher_exact([[n, 0], [0, n]]).pvalue == pytest.approx(p)
    assert least_p(100_000, 10**9) == 0
    assert least_p(3, 100) == 1


def test_holm_on_a_published_example() -> None:
    """R's p.adjust(c(0.01, 0.02, 0.03, 0.04, 0.05), 'holm')."""
    assert holm([0.01, 0.02, 0.03, 0.04, 0.05]) == pytest.approx([0.05, 0.08, 0.09, 0.09, 0.09])
    assert holm([0.04, 0.01, 0.9]) == pytest.approx([0.08, 0.03, 0.9])
    assert holm([]) == []


@pytest.mark.parametrize(
    ("low", "high", "name"),
    [
        (0.45, 0.55, "negligible"),
        (0.51, 0.55, "negligible"),
        (0.44, 0.56, ""),
        (0.51, 0.9, ""),
        (0.4, 1.0, ""),
        (0.56, 0.6, "at least small"),
        (0.1, 0.44, "at least small"),
        (0.64, 1.0, "at least medium"),
        (0.71, 1.0, "large"),
        (0.0, 0.29, "large"),
        (np.nan, np.nan, ""),
    ],
)
def test_an_effect_is_named_if_its_whole_interval_agrees(low, high, name) -> None:
    assert effect_name(low, high) == name
