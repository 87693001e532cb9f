"""Weights and learning rates of CMA-ES for given numbers of genes and samples."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import log


@dataclass(frozen=True, eq=False)
class Rates:
    """Parameters of Hansen 2016, "The CMA evolution strategy: a tutorial", table 1, eq. 49 to 58.

    Attributes:
        weights: weights of the samples from best to worst, (samples,); positive weights sum to 1.
        parents: number of positive weights, µ.
        mass: variance effective selection mass, µ_eff.
        step: learning rate of the path of the step size, c_σ.
        damping: damping of the step size, d_σ.
        path: learning rate of the path of the covariance, c_c.
        rank_one: learning rate of the covariance's rank-one update, c_1.
        rank_mu: learning rate of the covariance's rank-µ update, c_µ.
        length: expected length of a vector of standard normal numbers.
    """

    weights: NDArray[np.float64]
    parents: int
    mass: float
    step: float
    damping: float
    path: float
    rank_one: float
    rank_mu: float
    length: float


@lru_cache
def rates(genes: int, samples: int, *, separable: bool, active: bool) -> Rates:
    """Return the default weights and learning rates.

    Args:
        genes: number of genes, n.
        samples: number of samples in each update, λ.
        separable: whether to learn only variances, (n + 2) / 3 times as fast (Ros and Hansen 2008,
            "A simple modification in CMA-ES achieving linear time and space complexity").
        active: whether bad samples shrink the covariance (Jastrebski and Arnold 2006, "Improving
            evolution strategies through active covariance matrix adaptation").
    """
    raw = log((samples + 1) / 2) - log(np.arange(1, samples + 1))
    parents = samples // 2
    good, bad = raw[:parents], raw[parents:]
    mass = np.square(good.sum()) / np.square(good).sum()
    bad_mass = np.square(bad.sum()) / np.square(bad).sum()

    # 3 as in pycma. With the tutorial's 5, the area under the ECDF on BBOB with two genes is 3 %
    # smaller.
    step = (mass + 2) / (genes + mass + 3)
    damping = 1 + 2 * max(0.0, np.sqrt((mass - 1) / (genes + 1)) - 1) + step
    path = (4 + mass / genes) / (genes + 4 + 2 * mass / genes)
    rank_one = 2 / (np.square(genes + 1.3) + mass)
    rank_mu = 2 * (0.25 + mass - 2 + 1 / mass) / (np.square(genes + 2) + mass)
    faster = (genes + 2) / 3 if separable else 1.0
    rank_one = min(1.0, faster * rank_one)
    rank_mu = min(1 - rank_one, faster * rank_mu)

    total = 0.0
    if active:
        total = min(
            1 + rank_one / rank_mu,  # the covariance neither grows nor shrinks overall
            1 + 2 * bad_mass / (mass + 2),
            (1 - rank_one - rank_mu) / (genes * rank_mu),  # the covariance stays positive definite
        )
    weights = np.concatenate([good / good.sum(), total * bad / np.abs(bad).sum()])
    length = np.sqrt(genes) * (1 - 1 / (4 * genes) + 1 / (21 * genes * genes))
    weights.setflags(write=False)
    return Rates(weights, parents, mass, step, damping, path, rank_one, rank_mu, length)
