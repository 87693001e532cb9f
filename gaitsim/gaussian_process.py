"""A Gaussian process with a map of gaits as its prior mean."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    return np.asarray((1 + scaled + scaled**2 / 3) * np.exp(-scaled))


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
    from scipy.linalg import cho_factor, cho_solve, solve_triangular  # takes 0.1 s
    from scipy.spatial.distance import cdist

    if not len(tried):
        return Prediction(prior.copy(), np.ones(len(prior)))
    covariance = matern(cdist(points[tried], points), length_scale)  # (trials, members)
    factor = cho_factor(covariance[:, tried] + noise * np.eye(len(tried)), lower=True)
    weights = cho_solve(factor, measured - prior[tried])
    explained = solve_triangular(factor[0], covariance, lower=True)
    variance = 1 - np.einsum("tm,tm->m", explained, explained)
    return Prediction(prior + weights @ covariance, np.sqrt(np.maximum(variance, 0)))
