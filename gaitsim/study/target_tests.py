"""Tests of how often and how soon the repeats of two experiments reach a target.

As Arcuri & Briand recommend (2011, "A practical guide for using statistical tests to assess
randomized algorithms in software engineering"), successes are compared with Fisher's exact test,
and times with the rank test. All repeats that never reach the target tie after the slowest repeat
that does. As all repeats are censored at the same budget, this is Gehan's generalised Wilcoxon test
(1965, "A generalized Wilcoxon test for comparing arbitrarily singly-censored samples", Biometrika
52). Unlike the log-rank test, it is exact for few repeats, is defined even if no repeat succeeds,
and has A12 as its effect size.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.study.statistics import CONFIDENCE, effect_name, holm, rank_test


@dataclass(frozen=True)
class TargetTest:
    """Two experiments compared at a target.

    Attributes:
        target: score to reach.
        first, second: names of the experiments.
        p_success: p-value of Fisher's exact test of the numbers of successes.
        p_time: p-value of the rank test of the evaluations until the target is reached.
        p_success_holm, p_time_holm: p-values corrected for all pairs and targets (Holm 1979).
        a12: effect size of Vargha and Delaney: the share of pairs in which the first experiment's
            repeat reaches the target sooner than the second's; ties count half, and two repeats
            that never reach it tie.
        effect: 'negligible', 'small', 'medium' or 'large', according to `a12`.
    """

    target: float
    first: str
    second: str
    p_success: float
    p_success_holm: float
    p_time: float
    p_time_holm: float
    a12: float
    effect: str

    @property
    def success_differs(self) -> bool:
        """Whether the difference of successes is significant at 5 % after correction."""
        return self.p_success_holm < 1 - CONFIDENCE

    @property
    def time_differs(self) -> bool:
        """Whether the difference of times is significant at 5 % after correction."""
        return self.p_time_holm < 1 - CONFIDENCE

    def to_dict(self) -> dict[str, Any]:
        """Return the test as values for JSON."""
        verdicts = {"success_differs": self.success_differs, "time_differs": self.time_differs}
        return {**vars(self), **verdicts}


def compare_times(
    times: Mapping[float, Mapping[str, NDArray[np.float64]]],
) -> Sequence[TargetTest]:
    """Compare every pair of experiments at every target.

    Args:
        times: evaluations until each repeat reached the target, (repeats,), or ∞ if it did not; by
            target, then by the name of the experiment.
    """
    found = [
        (target, one, other, _successes(of[one], of[other]), *rank_test(of[other], of[one]))
        for target, of in times.items()
        for one, other in itertools.combinations(of, 2)
    ]
    successes = holm([p_success for *_, p_success, _, _ in found])
    times_corrected = holm([p_time for *_, p_time, _ in found])
    return [
        TargetTest(target, one, other, p, p_holm, q, q_holm, a12, effect_name(a12))
        for (target, one, other, p, q, a12), p_holm, q_holm in zip(
            found, successes, times_corrected, strict=True
        )
    ]


def _successes(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    from scipy.stats import fisher_exact

    counts = [(int(np.isfinite(one).sum()), len(one)) for one in (first, second)]
    # Sorted, so that the order of the experiments does not change the last bit.
    table = np.array([[reached, repeats - reached] for reached, repeats in sorted(counts)])
    return float(fisher_exact(table).pvalue)
