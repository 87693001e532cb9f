"""A Gaussian process with a map of gaits as its prior mean."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import cholesky, distances, exp, matmul, solve_triangular

Floats = NDArray[np.float64]


class Prediction(NamedTuple):
    """The predicted performance of each member of a map.

    Attributes:
        mean: expected performance, (members,).
        deviation: standard deviation, (members,).
    """

    mean: Floats
    deviation: Floats


def matern(distances: Floats, length_scale: float) -> Floats:
    """Return the Matérn covariance (ν = 5/2, variance 1) of points with the given distances.

    Source: Rasmussen and Williams 2006, "Gaussian Processes for Machine Learning", eq. 4.17.
    """
    scaled = np.sqrt(5) / length_scale * distances
    return np.asarray((1 + scaled + np.square(scaled) / 3) * exp(-scaled))


def posterior(
    prior: Floats,
    points: Floats,
    tried: NDArray[np.intp],
    measured: Floats,
    length_scale: float,
    noise: float,
) -> Prediction:
    """Predict the performance of all members of a map, given trials of some of them.

    The process models the difference between the trials and the map. Source: Rasmussen and
    Williams 2006, eq. 2.25, 2.26 and 2.38.

    Args:
        prior: performance according to the map, (members,).
        points: behaviour of the members, (members, axes).
        tried: indices of the tried members, (trials,).
        measured: measured performance of the tried members, (trials,).
        length_scale: length scale of the covariance.
        noise: variance of the noise in `measured`.
    """
    if not len(tried):
        return Prediction(prior.copy(), np.ones(len(prior)))
    covariance = matern(distances(points[tried], points), length_scale)  # (trials, members)
    lower = cholesky(covariance[:, tried] + noise * np.eye(len(tried)))
    # With K = L Lᵀ, kᵀ K⁻¹ y = (L⁻¹ k)ᵀ (L⁻¹ y): one substitution serves mean and variance.
    explained = solve_triangular(lower, covariance)
    surprise = solve_triangular(lower, (measured - prior[tried])[:, None])
    mean = prior + matmul(surprise.T, explained)[0]
    variance = 1 - np.square(explained).sum(axis=0)
    return Prediction(mean, np.sqrt(np.maximum(variance, 0)))
