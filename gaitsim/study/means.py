"""Means of repeats, with confidence intervals suitable for skewed, failed and huge scores."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
