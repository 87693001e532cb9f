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


@dataclass(frozen=True, eq=False)
class SearchNoise:
    """The noise of a search: what remains of values after means of designs and of replicates.

    Three replicates say little about the noise of one design, and designs differ: some fall now and
    then. So the variance of each is drawn towards that of all, as much as the variances of designs
    resemble each other (Smyth 2004, "Linear models and empirical Bayes methods").

    Attributes:
        deviations: standard deviation of each design, (designs,); NaN if it is unknown.
        freedom: degrees of freedom of each.
        replicates: number of replicates.
    """

    deviations: Floats
    freedom: float
    replicates: int

    @classmethod
    def of(cls, values: Floats) -> "SearchNoise":
        """Return the noise of values, (designs, replicates), in a randomised block design.

        A replicate is a block (Fisher 1935, "The Design of Experiments"): its gaits come from the
        same gait of the original. Designs with a value that is not finite are left out.
        """
        found = np.isfinite(values).all(axis=1)
        known, deviations = values[found], np.full(len(values), np.nan)
        designs, replicates = known.shape
        if designs < 2 or replicates < 2:
            return cls(deviations, 0, replicates)
        rest = known - known.mean(axis=1, keepdims=True) - known.mean(axis=0) + known.mean()
        own = replicates - 1
        squares = np.square(rest).sum(axis=1) * designs / (designs - 1) / own
        prior, freedom = _prior(squares, own)
        weight = 1.0 if math.isinf(freedom) else freedom / (freedom + own)
        deviations[found] = np.sqrt(weight * prior + (1 - weight) * squares)
        return cls(deviations, min(freedom + own, (designs - 1) * own), replicates)

    def p_values(self, means: Floats) -> Floats:
        """Return p-values that pairs of designs are equal, (designs, designs), two-sided.

        NaN where the noise is unknown.
        """
        from scipy.special import stdtr

        squares = np.square(self.deviations)
        errors = np.sqrt((squares[:, None] + squares) / self.replicates)
        apart = np.abs(means[:, None] - means)
        with np.errstate(invalid="ignore", divide="ignore"):
            ratios = np.where(apart == 0, 0.0, apart / errors)
        return np.asarray(2 * stdtr(max(self.freedom, 1), -ratios))


def _prior(squares: Floats, freedom: int) -> tuple[float, float]:
    """Return the variance to which those of designs are drawn, and its degrees of freedom.

    Args:
        squares: variances, (designs,).
        freedom: degrees of freedom of each.
    """
    from scipy.optimize import brentq
    from scipy.special import digamma, polygamma

    mean = float(squares.mean())
    logs = np.log(np.maximum(squares, 1e-12 * mean + 1e-300)) - digamma(freedom / 2)
    spread = float(logs.var(ddof=1)) - float(polygamma(1, freedom / 2))
    if spread <= 1e-3:  # no more than by chance
        return mean, math.inf
    half = float(brentq(lambda x: float(polygamma(1, x)) - spread, 1e-3, 1e4))
    log = float(logs.mean()) + math.log(freedom / 2) + float(digamma(half)) - math.log(half)
    return math.exp(log), 2 * half


def _differ(p_values: Floats) -> NDArray[np.bool_]:
    """Return which p-values are differences, with at most 5 % false ones among them.

    Source: Benjamini and Hochberg 1995, "Controlling the false discovery rate".
    """
    from scipy.stats import false_discovery_control

    found, known = np.zeros(p_values.shape, np.bool_), np.isfinite(p_values)
    if known.any():
        found[known] = false_discovery_control(p_values[known]) < 1 - CONFIDENCE
    return found


def differences(values: Floats, reference: int) -> NDArray[np.int64]:
    """Return 1 for designs above a reference, −1 below, 0 within the noise, (designs,).

    Args:
        values: values, (designs, replicates).
        reference: index of the design to compare with.
    """
    means, found = values.mean(axis=1), np.zeros(len(values), np.int64)
    others = np.arange(len(values)) != reference
    differ = _differ(SearchNoise.of(values).p_values(means)[reference, others])
    found[others] = np.where(differ, np.sign(means[others] - means[reference]), 0)
    return found


def plateau(values: Floats) -> NDArray[np.bool_]:
    """Return which designs cannot be distinguished from the best one, (designs,).

    All pairs of designs are compared, as the best one is known only by the same values. Without a
    known noise, the plateau is the best one alone.

    Args:
        values: values, (designs, replicates); higher is better.
    """
    means = np.where(np.isfinite(values).all(axis=1), values.mean(axis=1), -np.inf)
    found, best = np.isfinite(means), int(means.argmax())
    noise = SearchNoise.of(values)
    if not noise.freedom:
        return np.asarray(np.arange(len(means)) == best)
    p_values = noise.p_values(values.mean(axis=1))
    pairs = np.triu_indices(len(means), 1)
    differ = np.zeros(p_values.shape, np.bool_)
    differ[pairs] = _differ(p_values[pairs])
    return np.asarray(found & ~(differ | differ.T)[best], np.bool_)


@dataclass(frozen=True, eq=False)
class ResponseSurface:
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
    def fit(cls, points: Floats, values: Floats) -> "ResponseSurface | None":
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
    found = ResponseSurface.fit(points, values.mean(axis=1))
    each = [ResponseSurface.fit(points, column) for column in values.T]
    apart = [one.shares for one in each if one is not None]
    if found is None or not apart:
        nothing = np.full(points.shape[1], np.nan)
        return nothing, np.stack([nothing, nothing]), math.nan
    return found.shares, np.stack([np.min(apart, axis=0), np.max(apart, axis=0)]), found.r_squared
