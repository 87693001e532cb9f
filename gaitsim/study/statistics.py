"""Statistics over repeated runs of randomised algorithms.

As recommended by Arcuri & Briand (2011, "A practical guide for using statistical tests to assess
randomized algorithms in software engineering"): medians with confidence intervals, a rank
test with correction for multiple comparisons, and an effect size that does not assume normality.
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

# Least distance from 1/2 for each name of an effect, from Vargha & Delaney (2000).
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
    """Describe a sample, with a 95 % percentile bootstrap interval of its median.

    Args:
        values: values of the sample, (n,).
        rng: random generator of the resamples.
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
    sample: Sequence[NDArray[np.float64]], statistic: Callable[..., Any], rng: np.random.Generator
) -> tuple[float, float]:
    """Return the 95 % percentile bootstrap interval of a statistic.

    Args:
        sample: columns of the sample, (n,) each; rows are resampled.
        statistic: function of the columns along an `axis`.
        rng: random generator of the resamples.
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
    """A test of the difference between two samples.

    Attributes:
        first, second: names of the samples.
        p: two-sided p-value of the Mann–Whitney U test; see `rank_test`.
        p_holm: p-value corrected for all comparisons (Holm 1979).
        a12: effect size of Vargha and Delaney: the share of pairs in which the first sample's value
            exceeds the second's; ties count half. It is 1/2 if neither tends to be larger.
        effect: 'negligible', 'small', 'medium' or 'large', according to `a12`.
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


EXACT = 60
"""Largest number of values in two samples together for an exact test."""


def compare(samples: Mapping[str, ArrayLike]) -> list[PairTest]:
    """Compare every pair of samples, (n,) each, by name."""
    pairs = list(itertools.combinations(samples, 2))
    tests = [rank_test(samples[one], samples[other]) for one, other in pairs]
    corrected = holm([p for p, _ in tests])
    return [
        PairTest(one, other, p, p_holm, a12, effect_name(a12))
        for (one, other), (p, a12), p_holm in zip(pairs, tests, corrected, strict=True)
    ]


def rank_test(first: ArrayLike, second: ArrayLike) -> tuple[float, float]:
    """Return the two-sided p-value of the Mann–Whitney U test, and A12 = U / (n m).

    For at most `EXACT` values, the p-value is exact even with ties: twice the smaller tail over all
    assignments of the ranks. Otherwise it is the normal approximation, corrected for ties and
    continuity. Exchanging the samples gives the same p-value to the last bit.

    Args:
        first: first sample, (n,).
        second: second sample, (m,).
    """
    from scipy.stats import mannwhitneyu, rankdata

    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    n, m = len(one), len(other)
    ranks = rankdata(np.concatenate([one, other]))
    u = float(ranks[:n].sum()) - n * (n + 1) / 2
    if np.ptp(ranks) == 0:
        p = 1.0  # the test is undefined if all values are equal
    elif n + m <= EXACT:
        p = _exact(ranks, n)
    else:
        p = float(mannwhitneyu(ranks[:n], ranks[n:]).pvalue)
    return p, u / (n * m)


def _exact(ranks: NDArray[np.float64], n: int) -> float:
    """Return twice the smaller tail of the rank sum of the first n values.

    Uses the shift algorithm (Streitberg & Röhmel 1986), which counts the ways to choose n ranks
    with each sum. With ties, SciPy enumerates all choices: 0.2 s for two samples of eight, against
    0.3 ms here.
    """
    doubled = np.rint(2 * ranks).astype(int)  # tied ranks may be multiples of 1/2
    total, observed = int(doubled.sum()), int(doubled[:n].sum())
    # For the same result with exchanged samples, take the smaller sample, or the smaller sum.
    taken = min(n, len(ranks) - n)
    if taken < n or (2 * n == len(ranks) and 2 * observed > total):
        observed = total - observed
    ways = np.zeros((taken + 1, total + 1))
    ways[0, 0] = 1
    for rank in np.sort(doubled).tolist():
        ways[1:, rank:] += ways[:-1, :-rank].copy()
    below, above = ways[taken, : observed + 1].sum(), ways[taken, observed:].sum()
    return min(1.0, 2 * float(min(below, above)) / math.comb(len(ranks), taken))


def least_p(repeats: int, tests: int) -> float:
    """Return the smallest possible corrected p-value of exact tests of two samples.

    It occurs if all values of one sample exceed all values of the other, in 2 of all assignments of
    the ranks. It applies to the rank test and to Fisher's test.

    Args:
        repeats: number of values in each sample.
        tests: number of tests to correct for.
    """
    ways = math.lgamma(2 * repeats + 1) - 2 * math.lgamma(repeats + 1)  # logarithm of the number
    return min(1.0, 2 * tests * math.exp(-ways))


def holm(p_values: Sequence[float]) -> list[float]:
    """Correct p-values for multiple comparisons with Holm's step-down procedure (1979)."""
    order = np.argsort(p_values, kind="stable")
    corrected = [0.0] * len(p_values)
    highest = 0.0
    for rank, index in enumerate(order.tolist()):
        highest = max(highest, min(1.0, (len(p_values) - rank) * p_values[index]))
        corrected[index] = highest
    return corrected


def effect_name(a12: float) -> str:
    """Return the conventional name of an effect size A12."""
    # Rounded, because 0.5 + 0.06 − 0.5 is not 0.06 in floating point.
    distance = round(abs(a12 - 0.5), 12)
    return next((name for bound, name in _EFFECTS if distance >= bound), "negligible")


Values = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Means:
    """Means over repeats of the best score so far, at each recorded generation.

    Attributes:
        repeats: number of repeats.
        mean: mean, (generations,); −inf if a repeat has no finite score.
        error: standard error of the mean, (generations,); NaN if undefined.
        skew: skewness of the scores, (generations,); 0 if all are equal.
    """

    repeats: int
    mean: Values
    error: Values
    skew: Values

    @classmethod
    @np.errstate(invalid="ignore", over="ignore", divide="ignore")
    def of(cls, best: Values) -> "Means":
        """Return the means of best scores, (repeats, generations)."""
        repeats, generations = best.shape
        mean = best.mean(axis=0)
        if repeats < 2:
            nothing = np.full(generations, np.nan)
            return cls(repeats, mean, nothing, nothing)
        spread = best.std(axis=0, ddof=1)
        skew = np.where(spread > 0, (((best - mean) / spread) ** 3).mean(axis=0), 0.0)
        return cls(repeats, mean, spread / np.sqrt(repeats), skew)

    def interval(self, level: float) -> tuple[Values, Values]:
        """Return the ends of the confidence intervals of the means.

        The intervals are Student's t after Hall's transformation (1992, "On the removal of
        skewness by transformation", equation 3). Best scores near an optimum are skewed: most
        repeats reach it, and a few stay far below. Without the transformation, with 1,000 repeats,
        the lower end of a 99.5 % interval exceeds the true mean of the millipede's scores five
        times as often as it should.

        An unknown end is infinite. The interval of a mean of −inf is −inf to −inf, so such a
        generation never reaches a target.

        Args:
            level: probability that an interval covers the true mean, such as 0.95.
        """
        from scipy.special import stdtrit

        low, high = np.full_like(self.mean, -np.inf), np.full_like(self.mean, np.inf)
        high[np.isneginf(self.mean)] = -np.inf
        known = np.isfinite(self.mean) & np.isfinite(self.error) & np.isfinite(self.skew)
        mean, error = self.mean[known], self.error[known]
        skew = self.skew[known] / np.sqrt(self.repeats)
        quantile = float(stdtrit(max(self.repeats - 1, 1), (1 + level) / 2))
        low[known] = mean - error * _untransformed(quantile, skew)
        high[known] = mean - error * _untransformed(-quantile, skew)
        return low, high


def _untransformed(quantile: float, skew: Values) -> Values:
    """Solve Hall's T + γT²/3 + γ²T³/27 + γ/6 = quantile for T, where γ = skew / √n."""
    unskewed = np.abs(skew) < 1e-9
    gamma = np.where(unskewed, 1.0, skew)
    found = 3 / gamma * (np.cbrt(1 + gamma * (quantile - gamma / 6)) - 1)
    return np.where(unskewed, quantile, found)


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


def compare_times(times: Mapping[float, Mapping[str, NDArray[np.float64]]]) -> Sequence[TargetTest]:
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
