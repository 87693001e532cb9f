import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from gaitsim.study.statistics import compare, describe, effect_name, holm, least_p, rank_test

SAMPLES = st.lists(st.integers(0, 9), min_size=2, max_size=20)


def test_description_of_a_known_sample() -> None:
    found = describe([1, 2, 3, 4, 100], np.random.default_rng(0))
    assert (found.n, found.median, found.q25, found.q75) == (5, 3, 2, 4)
    assert (found.minimum, found.maximum, found.mean) == (1, 100, 22)
    assert found.std == pytest.approx(np.std([1, 2, 3, 4, 100], ddof=1))
    assert found.median_low <= found.median <= found.median_high


@pytest.mark.slow
def test_the_interval_of_the_median_has_its_confidence_level() -> None:
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(200):
        found = describe(rng.exponential(1.0, 40), rng)
        covered += found.median_low <= np.log(2) <= found.median_high
    # 95 % of 200, within three standard deviations of a binomial count and the
    # percentile method's known small error
    assert 178 <= covered <= 199


def test_the_interval_of_a_constant_sample_has_zero_width() -> None:
    found = describe([2.0] * 7, np.random.default_rng(0))
    assert (found.median_low, found.median_high, found.std) == (2, 2, 0)


@given(SAMPLES, SAMPLES)
def test_a12_is_the_share_of_pairs_won(first: list[int], second: list[int]) -> None:
    a, b = np.array(first)[:, None], np.array(second)[None, :]
    expected = ((a > b) + 0.5 * (a == b)).mean()
    (found,) = compare({"a": first, "b": second})
    assert found.a12 == pytest.approx(expected)


def test_the_rank_test_agrees_with_scipy() -> None:
    rng = np.random.default_rng(2)
    first, second = rng.normal(0, 1, 40), rng.normal(1, 1, 35)
    (found,) = compare({"a": first, "b": second})
    assert found.p == stats.mannwhitneyu(first, second).pvalue
    assert found.p_holm == found.p
    assert found.differs
    few = stats.mannwhitneyu(first[:30], second[:28], method="exact")
    assert rank_test(first[:30], second[:28])[0] == pytest.approx(few.pvalue)


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


def test_equal_constants_do_not_differ() -> None:
    (found,) = compare({"a": [1.0, 1.0], "b": [1.0, 1.0, 1.0]})
    assert (found.p, found.a12, found.effect, found.differs) == (1, 0.5, "negligible", False)


def test_holm_on_a_published_example() -> None:
    """R's p.adjust(c(0.01, 0.02, 0.03, 0.04, 0.05), 'holm')."""
    assert holm([0.01, 0.02, 0.03, 0.04, 0.05]) == pytest.approx([0.05, 0.08, 0.09, 0.09, 0.09])
    assert holm([0.04, 0.01, 0.9]) == pytest.approx([0.08, 0.03, 0.9])
    assert holm([]) == []


@pytest.mark.parametrize(
    ("a12", "name"),
    [
        (0.5, "negligible"),
        (0.55, "negligible"),
        (0.56, "small"),
        (0.44, "small"),
        (0.64, "medium"),
        (0.71, "large"),
        (0.0, "large"),
    ],
)
def test_effects_have_their_conventional_names(a12: float, name: str) -> None:
    assert effect_name(a12) == name
