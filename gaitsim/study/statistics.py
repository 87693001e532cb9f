"""Statistics over repeated runs, as reviewers of randomised algorithms expect them.

After Arcuri & Briand (2011, "A practical guide for using statistical tests to assess
randomized algorithms in software engineering"): medians with confidence intervals, a rank
test with correction for many comparisons, and an effect size that needs no normality.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

CONFIDENCE = 0.95
RESAMPLES = 9999
MOST_RESAMPLED = 2**23  # values at a time, 64 MB

# Vargha & Delaney (2000): from which distance to 1/2 an effect is called so.
_EFFECTS = ((0.21, "large"), (0.14, "medium"), (0.06, "small"))


@dataclass(frozen=True)
class Description:
    """Descriptive statistics of a sample.

    Attributes:
        n: number of values.
        mean, std, median, q25, q75, minimum, maximum: statistics of the values.
        median_low, median_high: bootstrap confidence interval of the median.
    """

    n: int
    mean: float
    std: float
    median: float
    q25: float
    q75: float
    minimum: float
    maximum: float
    median_low: float
    median_high: float


def describe(values: ArrayLike, rng: np.random.Generator) -> Description:
    """Describe a sample, (n,), with a 95 % percentile bootstrap interval of its median.

    Args:
        values: the sample.
        rng: draws the resamples.
    """
    sample = np.asarray(values, dtype=np.float64)
    q25, median, q75 = np.quantile(sample, [0.25, 0.5, 0.75])
    low, high = interval((sample,), np.median, rng)
    return Description(
        n=len(sample),
        mean=float(sample.mean()),
        std=float(sample.std(ddof=1)) if len(sample) > 1 else 0.0,
        median=float(median),
        q25=float(q25),
        q75=float(q75),
        minimum=float(sample.min()),
        maximum=float(sample.max()),
        median_low=low,
        median_high=high,
    )


def interval(
    sample: Sequence[NDArray[np.float64]],
    statistic: Callable[..., Any],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the 95 % percentile bootstrap interval of a statistic.

    Args:
        sample: columns of the sample, (n,) each; their rows are resampled.
        statistic: of the columns, along an `axis`.
        rng: draws the resamples.
    """
    from scipy.stats import bootstrap

    if all(np.ptp(column) == 0 for column in sample):  # nothing to resample
        value = float(statistic(*sample))
        return value, value
    found = bootstrap(
        sample,
        statistic,
        n_resamples=RESAMPLES,
        batch=max(1, MOST_RESAMPLED // len(sample[0])),
        vectorized=True,
        paired=True,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=rng,
    ).confidence_interval
    return float(found.low), float(found.high)


@dataclass(frozen=True)
class PairTest:
    """Two samples compared.

    Attributes:
        first, second: their names.
        p: two-sided p-value of the Mann–Whitney U test.
        p_holm: the same, corrected for all comparisons made (Holm 1979).
        a12: Vargha–Delaney: how often a value of the first exceeds one of the second,
            ties half; 1/2 where neither tends to be larger.
        effect: 'negligible', 'small', 'medium' or 'large', by `a12`.
    """

    first: str
    second: str
    p: float
    p_holm: float
    a12: float
    effect: str

    @property
    def differs(self) -> bool:
        """Whether the difference is significant at 5 % after correction."""
        return self.p_holm < 1 - CONFIDENCE


MAX_PERMUTATIONS = 20_000
"""Samples with no more permutations than this are tested exactly: two of eight values, say."""


def compare(samples: Mapping[str, ArrayLike]) -> list[PairTest]:
    """Compare every pair of samples, by name, each (n,)."""
    pairs = list(itertools.combinations(samples, 2))
    tests = [_mann_whitney(samples[one], samples[other]) for one, other in pairs]
    corrected = holm([p for p, _ in tests])
    return [
        PairTest(one, other, p, p_holm, a12, effect_name(a12))
        for (one, other), (p, a12), p_holm in zip(pairs, tests, corrected, strict=True)
    ]


def _mann_whitney(first: ArrayLike, second: ArrayLike) -> tuple[float, float]:
    """Return the p-value and A12 = U / (n m)."""
    from scipy.stats import PermutationMethod, mannwhitneyu

    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if np.ptp(np.concatenate([one, other])) == 0:
        return 1.0, 0.5  # the test is undefined where all values are equal
    permutations = math.comb(len(one) + len(other), len(one))
    # SciPy's exact test does not allow ties, which scores often have. For few values its
    # approximation is below the least possible p: 0.0071 for five and five, not 2 in 252.
    if permutations <= MAX_PERMUTATIONS:
        result = mannwhitneyu(one, other, method=PermutationMethod(n_resamples=permutations))
    else:
        result = mannwhitneyu(one, other)
    return float(result.pvalue), float(result.statistic) / (len(one) * len(other))


def holm(p_values: Sequence[float]) -> list[float]:
    """Correct p-values for multiple comparisons by Holm's step-down procedure (1979)."""
    order = np.argsort(p_values, kind="stable")
    corrected = [0.0] * len(p_values)
    highest = 0.0
    for rank, index in enumerate(order.tolist()):
        highest = max(highest, min(1.0, (len(p_values) - rank) * p_values[index]))
        corrected[index] = highest
    return corrected


def effect_name(a12: float) -> str:
    """Return the conventional name of an effect size A12."""
    # Rounded, as 0.5 + 0.06 − 0.5 is not 0.06.
    distance = round(abs(a12 - 0.5), 12)
    return next((name for bound, name in _EFFECTS if distance >= bound), "negligible")
