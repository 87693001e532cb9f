"""The first generation of searches that breed; crossover and mutation of NSGA-II."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, RealSpace, option
from gaitsim.plugin.toolkit import power

START_SHARE: float = option(
    0.1,
    "share of the first population that consists of start points and mutants of them, if the body "
    "has start points; the rest is random",
    gt=0,
    le=1,
)


def simulated_binary(
    parents: Genomes,
    crossed: NDArray[np.bool_],
    eta: float,
    space: RealSpace,
    rng: np.random.Generator,
) -> Genomes:
    """Place two children symmetrically about the middle of their parents, mostly near the parents.

    SBX of Deb and Agrawal 1995, with the bounds of Deb 2000, "An efficient constraint handling
    method for genetic algorithms". For each gene, a random child gets the lower value. A periodic
    gene has no bounds, and the middle of its parents is on the shorter way round.

    Args:
        parents: genomes of the parents, (2, pairs, genes).
        crossed: genes to cross, (pairs, genes); children inherit the other genes unchanged.
        eta: distribution index; larger values keep children closer to their parents.
        space: bounds of the genes.
        rng: source of randomness.

    Returns:
        Children, (2, pairs, genes). They must be repaired: periodic genes may be outside their
        period, and rounding may push other genes past a bound.
    """
    mothers, fathers = parents
    gap = fathers - mothers
    periodic = np.zeros(space.genes, np.bool_) if space.periodic is None else space.periodic
    gap = np.where(periodic, gap - space.width * np.round(gap / space.width), gap)
    sites = np.nonzero(crossed & (gap != 0))
    gene, mother, gap = sites[1], mothers[sites], gap[sites]
    distance = np.abs(gap)
    low = np.minimum(mother, mother + gap)
    below = np.where(periodic[gene], np.inf, low - space.lower[gene])
    above = np.where(periodic[gene], np.inf, space.upper[gene] - low - distance)
    draws = rng.random((2, len(gene)))
    middle = low + distance / 2
    lower = middle - distance / 2 * _spread(draws[0], below / distance, eta)
    upper = middle + distance / 2 * _spread(draws[0], above / distance, eta)
    swapped = draws[1] < 0.5
    children = parents.copy()
    children[0][sites] = np.where(swapped, lower, upper)
    children[1][sites] = np.where(swapped, upper, lower)
    return children


def _spread(
    draws: NDArray[np.float64], room: NDArray[np.float64], eta: float
) -> NDArray[np.float64]:
    """Return the distance of the children, relative to the distance of the parents.

    Args:
        draws: uniform draws in [0, 1).
        room: distance from the nearest parent to the bound, in distances between the parents.
        eta: distribution index.
    """
    # Rounding in `low + distance` may put a parent just past its bound.
    share = draws * (2 - power(1 + 2 * np.maximum(room, 0), -(eta + 1)))
    return power(np.where(share <= 1, share, 1 / (2 - share)), 1 / (eta + 1))


def polynomial(
    genomes: Genomes,
    mutated: NDArray[np.bool_],
    eta: float,
    space: RealSpace,
    rng: np.random.Generator,
) -> Genomes:
    """Move genes by polynomially distributed steps that stay within the bounds.

    Deb and Agrawal 1999, in the form with bounds. Periodic genes have no bounds.

    Args:
        genomes: genomes, (individuals, genes).
        mutated: genes to move, (individuals, genes).
        eta: distribution index; larger values make steps shorter.
        space: bounds of the genes.
        rng: source of randomness.

    Returns:
        New genomes, (individuals, genes), which must be repaired.
    """
    sites = np.nonzero(mutated)
    gene = sites[1]
    below = (genomes[sites] - space.lower[gene]) / space.width[gene]
    above = 1 - below
    if space.periodic is not None:
        below = np.where(space.periodic[gene], 1.0, below)
        above = np.where(space.periodic[gene], 1.0, above)
    draws = rng.random(len(gene))
    down = draws < 0.5
    tail = np.where(down, 2 * draws, 2 - 2 * draws)
    beyond = 1 - np.where(down, below, above)
    step = 1 - power(tail + (1 - tail) * power(beyond, eta + 1), 1 / (eta + 1))
    mutants = genomes.copy()
    mutants[sites] += np.where(down, -step, step) * space.width[gene]
    return mutants


def exchange_segment(
    parents: Genomes, crossed: NDArray[np.bool_], rng: np.random.Generator
) -> Genomes:
    """Exchange the genes between two random cuts, which may be at the ends (De Jong 1975).

    Args:
        parents: genomes of the parents, (2, pairs, genes).
        crossed: pairs to cross, (pairs,).
        rng: source of randomness.

    Returns:
        Children, (2, pairs, genes).
    """
    _, pairs, genes = parents.shape
    one = rng.integers(0, genes + 1, (pairs, 1))
    other = rng.integers(0, genes, (pairs, 1))
    other += other >= one
    place = np.arange(genes)
    inside = (place >= one) != (place >= other)
    return np.where(inside & crossed[:, None], parents[::-1], parents)
