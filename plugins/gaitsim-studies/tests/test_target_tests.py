import numpy as np
import pytest
from scipy import stats

from gaitsim_studies.statistics import compare

NEVER = np.inf
ONE = np.array([10.0, 20.0, 20.0, NEVER, NEVER])
OTHER = np.array([20.0, NEVER, NEVER, NEVER, NEVER])


def test_successes_and_times_of_a_small_example() -> None:
    _, (found,) = compare({"a": ONE, "b": OTHER}, {2.5: {"a": ONE, "b": OTHER}})
    # 3 of 5 and 1 of 5: of the 10 choose 4 tables, 2 · (5·10 + 5) are at least as unlikely.
    assert found.p_success == pytest.approx(110 / 210)
    # a is sooner in 4 + 4 + 5 of 25 pairs; 2 · 1 pairs tie at 20, and 2 · 4 without success.
    assert found.a12 == pytest.approx((13 + 5) / 25)
    # Any value above all others can represent no success: Gehan's test with equal censoring.
    ends = [np.where(np.isinf(one), 999, one) for one in (ONE, OTHER)]
    exact = stats.mannwhitneyu(*ends, method=stats.PermutationMethod(n_resamples=252))
    assert found.p_time == pytest.approx(exact.pvalue)
    assert (found.success_differs, found.time_differs) == (False, False)


def test_all_tests_are_corrected_together() -> None:
    fast, slow = np.arange(1.0, 13), np.full(12, NEVER)
    scores, found = compare(
        dict.fromkeys("abc", fast),
        {1.0: {"a": fast, "b": slow, "c": fast}, 9.0: {"a": slow, "b": slow, "c": slow}},
    )
    assert [(one.target, one.first, one.second) for one in found][2:4] == [
        (1.0, "b", "c"),
        (9.0, "a", "b"),
    ]
    least = 2 / 2704156  # 24 choose 12
    assert found[0].p_time == found[0].p_success == pytest.approx(least)
    assert found[0].p_time_holm == found[0].p_success_holm == pytest.approx(15 * least)
    assert [one.p_holm for one in scores] == [1, 1, 1]
    assert (found[0].success_differs, found[0].time_differs, found[0].a12) == (True, True, 1)
    assert found[2].a12 == 0
    assert [(one.p_time, one.p_success, one.a12) for one in found[3:]] == 3 * [(1, 1, 0.5)]
