import numpy as np
import pytest

from gaitsim_studies.runtimes import TARGETS, ecdf, spaced_targets, summarise_target

# Three repeats of three generations of ten individuals.
BEST = np.array([[1.0, 5.0, 5.0], [1.0, 2.0, 3.0], [5.0, 5.0, 5.0]])
EVALUATIONS = np.array([10, 20, 30])


def test_expected_running_time_counts_failures() -> None:
    found = summarise_target(BEST, EVALUATIONS, 5.0)
    assert (found.successes, found.repeats) == (2, 3)
    assert found.ert == (20 + 30 + 10) / 2
    assert found.rate == pytest.approx(2 / 3)
    assert np.isnan([found.low, found.high]).all()  # three repeats are too few
    never = summarise_target(np.tile(BEST, (2, 1)), EVALUATIONS, 6.0)
    lost = (1 - never.rate_high) / never.rate_high * 30
    assert (never.ert, never.low, never.high) == (np.inf, pytest.approx(10 + lost), np.inf)
    always = summarise_target(np.tile(BEST, (2, 1)), EVALUATIONS, 1.0)
    assert (always.ert, always.low) == (10, 10)
    lost = (1 - always.rate_low) / always.rate_low * 30  # failures may have been missed
    assert always.high == pytest.approx(10 + lost)


@pytest.mark.parametrize("p", [0.02, 0.3, 0.6])
def test_the_interval_of_an_ert_has_its_confidence_level(p: float) -> None:
    """Runs last at most 5 generations of 1, each of which succeeds with probability p."""
    last = 5
    truth = 1 / p  # the number of restarts until success has a geometric distribution
    draws, covered = np.random.default_rng(3), 0
    for _ in range(200):
        runtime = draws.geometric(p, 20)
        best = (np.arange(1, last + 1) >= runtime[:, None]).astype(float)
        found = summarise_target(best, np.arange(1, last + 1), 1.0)
        covered += found.low <= truth <= found.high
    assert covered >= 185


def test_ecdf_and_area_of_a_small_example() -> None:
    found = ecdf(BEST, EVALUATIONS, 50, np.array([1.0, 2.0, 3.0, 5.0]))
    # Of 12 pairs: after one generation 1 + 1 + 4, after two 4 + 2 + 4, after three 4 + 3 + 4.
    assert found.share.tolist() == [6 / 12, 10 / 12, 11 / 12]
    # Zero for ten evaluations, then three steps, the last one twice as long.
    assert found.area == pytest.approx((6 + 10 + 11 + 11) / 12 / 5)
    assert np.isnan([found.low, found.high]).all()  # three repeats are too few


def test_targets_lie_between_the_worst_start_and_the_best_end() -> None:
    other = np.array([[-2.0, 0.0], [0.0, 9.0]])
    found = spaced_targets([BEST, other])
    assert (found[0], found[-1], len(found)) == (-1, 9, TARGETS)
    assert np.diff(found) == pytest.approx(10 / (TARGETS - 1))
    failed = np.array([[-np.inf, 2.0], [-np.inf, 3.0]])
    assert spaced_targets([failed])[[0, -1]].tolist() == [2, 3]
    assert spaced_targets([np.array([[4.0], [4.0]])]).tolist() == [4]
    assert np.isfinite(spaced_targets([np.array([[-1.7e308, 1.7e308]])])).all()
