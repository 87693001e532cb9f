"""A Gaussian process whose prior mean is a map of gaits."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Belief(NamedTuple):
    """The performance that each member of a map is believed to have.

    Attributes:
        mean: (members,).
        deviation: standard deviation, (members,).
    """

    mean: Floats
    deviation: Floats


def matern(distances: Floats, length_scale: float) -> Floats:
    """Return the Matérn covariance with ν = 5/2 and variance 1 of points by their distances.

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
) -> Belief:
    """Return the belief about all members of a map after some of them were tried.

    Source: Rasmussen and Williams 2006, eq. 2.25, 2.26 and 2.38: the process models what the
    trials differ by from the map.

    Args:
        prior: performance by the map, (members,).
        points: behaviour, (members, axes).
        tried: indices of the members that were tried, (trials,).
        measured: their performance, (trials,).
        length_scale: of the covariance.
        noise: variance of `measured`.
    """
    from scipy.linalg import cho_factor, cho_solve, solve_triangular  # 0.1 s
    from scipy.spatial.distance import cdist

    if not len(tried):
        return Belief(prior.copy(), np.ones(len(prior)))
    covariance = matern(cdist(points[tried], points), length_scale)  # (trials, members)
    factor = cho_factor(covariance[:, tried] + noise * np.eye(len(tried)), lower=True)
    weights = cho_solve(factor, measured - prior[tried])
    explained = solve_triangular(factor[0], covariance, lower=True)
    variance = 1 - np.einsum("tm,tm->m", explained, explained)
    return Belief(prior + weights @ covariance, np.sqrt(np.maximum(variance, 0)))
