"""Statistics of maps of designs: noise of the search, intervals, plateaus and response surfaces."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONFIDENCE = 0.95


def intervals(values: Floats) -> tuple[Floats, Floats]:
    """Return means and half widths of Student's 95 % intervals over replicates, (designs,) each.

    Args:
        values: values, (designs, replicates). A half width is NaN for a single replicate.
    """
    from scipy.special import stdtrit

    count = values.shape[1]
    with np.errstate(invalid="ignore"):
        means = values.mean(axis=1)
        if count < 2:
            return means, np.full(len(values), np.nan)
        errors = values.std(axis=1, ddof=1) / math.sqrt(count)
    return means, float(stdtrit(count - 1, (1 + CONFIDENCE) / 2)) * errors


@dataclass(frozen=True)
class Noise:
    """The noise of a search: what remains of values after means of designs and of replicates.

    Attributes:
        deviation: its standard deviation; NaN for fewer than two designs or replicates.
        freedom: degrees of freedom.
        replicates: number of replicates.
    """

    deviation: float
    freedom: int
    replicates: int

    @classmethod
    def of(cls, values: Floats) -> "Noise":
        """Return the noise of values, (designs, replicates), in a randomised block design.

        A replicate is a block (Fisher 1935, "The Design of Experiments"): its gaits come from the
        same gait of the original. Designs with a value that is not finite are left out.
        """
        known = values[np.isfinite(values).all(axis=1)]
        designs, replicates = known.shape
        freedom = (designs - 1) * (replicates - 1)
        if freedom < 1:
            return cls(math.nan, 0, replicates)
        rest = known - known.mean(axis=1, keepdims=True) - known.mean(axis=0) + known.mean()
        return cls(math.sqrt(float(np.square(rest).sum()) / freedom), freedom, replicates)

    def margin(self, comparisons: int) -> float:
        """Return the smallest difference of two means that is more than noise.

        With 95 % confidence, none of so many comparisons is wrong (Bonferroni). NaN if the noise is
        unknown.
        """
        from scipy.special import stdtrit

        if not self.freedom:
            return math.nan
        level = 1 - (1 - CONFIDENCE) / (2 * max(comparisons, 1))
        error = self.deviation * math.sqrt(2 / self.replicates)
        return float(stdtrit(self.freedom, level)) * error


def differences(values: Floats, reference: int) -> NDArray[np.int64]:
    """Return 1 for designs above a reference, −1 below, 0 within the noise, (designs,).

    Args:
        values: values, (designs, replicates).
        reference: index of the design to compare with.
    """
    margin = Noise.of(values).margin(len(values) - 1)
    means = values.mean(axis=1)
    with np.errstate(invalid="ignore"):
        change = np.where(np.isfinite(means), means - means[reference], 0.0)
        return np.where(np.abs(change) > margin, np.sign(change), 0).astype(np.int64)


def pairs(designs: int) -> int:
    """Return the number of pairs of designs."""
    return designs * (designs - 1) // 2


def plateau(values: Floats) -> NDArray[np.bool_]:
    """Return which designs cannot be distinguished from the best one, (designs,).

    The margin holds for all pairs of designs, as the best one is known only by the same values.
    Without a known noise, the plateau is the best one alone.

    Args:
        values: values, (designs, replicates); higher is better.
    """
    means = np.where(np.isfinite(values).all(axis=1), values.mean(axis=1), -np.inf)
    margin = Noise.of(values).margin(pairs(len(values)))
    best = means.max(initial=-np.inf)
    lowest = best if math.isnan(margin) else best - margin
    return np.asarray((means >= lowest) & np.isfinite(means), np.bool_)


@dataclass(frozen=True, eq=False)
class Surface:
    """A quadratic response surface (Box and Wilson 1951), fitted by least squares.

    Attributes:
        coefficients: of the constant; of P₁ and P₂, Legendre polynomials, of each dimension; and of
            the products of two dimensions.
        r_squared: share of the variance that it explains.
        dimensions: number of dimensions.
    """

    coefficients: Floats
    r_squared: float
    dimensions: int

    @classmethod
    def fit(cls, points: Floats, values: Floats) -> "Surface | None":
        """Return the surface of values; None for too few designs or without any differences.

        Args:
            points: designs, (designs, dimensions), scaled to −1 to 1.
            values: values, (designs,); those that are not finite are left out.
        """
        known = np.isfinite(values)
        points, values = points[known], values[known]
        terms = _terms(points)
        total = float(np.square(values - values.mean()).sum()) if len(values) else 0.0
        if len(values) <= terms.shape[1] or total <= 0:
            return None
        found, _, rank, _ = np.linalg.lstsq(terms, values)
        if rank < terms.shape[1]:
            return None
        rest = float(np.square(values - terms @ found).sum())
        return cls(np.asarray(found, np.float64), 1 - rest / total, points.shape[1])

    @property
    def shares(self) -> Floats:
        """The share of each dimension in the variance of the surface, (dimensions,).

        These are first-order Sobol indices for designs that are uniform in the ranges: P₁ has the
        variance 1/3, P₂ 1/5, and a product of two P₁ 1/9. Interactions have the rest.
        """
        count = self.dimensions
        squares = np.square(self.coefficients)
        first, second = squares[1 : 1 + count], squares[1 + count : 1 + 2 * count]
        alone = first / 3 + second / 5
        total = alone.sum() + squares[1 + 2 * count :].sum() / 9
        return np.asarray(alone / total if total > 0 else np.full(count, np.nan))

    def effect(self, dimension: int, points: Floats) -> Floats:
        """Return the mean over the other dimensions at points, (points,), of one dimension."""
        first, second = 1 + dimension, 1 + dimension + self.dimensions
        one, two = self.coefficients[[first, second]]
        return np.asarray(self.coefficients[0] + one * points + two * _second(points))


def _terms(points: Floats) -> Floats:
    """Return the terms of a quadratic surface at points, (points, terms)."""
    columns: Sequence[Floats] = [
        np.ones(len(points)),
        *points.T,
        *_second(points).T,
        *(one * other for one, other in combinations(points.T, 2)),
    ]
    return np.stack(columns, axis=1)


def _second(points: Floats) -> Floats:
    """Return the second Legendre polynomial."""
    return np.asarray((3 * np.square(points) - 1) / 2)


def shares(points: Floats, values: Floats) -> tuple[Floats, Floats, float]:
    """Return the share of each dimension in the variance, its range over replicates, and R².

    Shares, (dimensions,), and R² are those of the surface of the means. The smallest and largest
    shares, (2, dimensions), are those of the surfaces of single replicates. All are NaN without a
    surface.

    Args:
        points: designs, (designs, dimensions), scaled to −1 to 1.
        values: values, (designs, replicates).
    """
    found = Surface.fit(points, values.mean(axis=1))
    each = [Surface.fit(points, column) for column in values.T]
    apart = [one.shares for one in each if one is not None]
    if found is None or not apart:
        nothing = np.full(points.shape[1], np.nan)
        return nothing, np.stack([nothing, nothing]), math.nan
    return found.shares, np.stack([np.min(apart, axis=0), np.max(apart, axis=0)]), found.r_squared
