"""Polynomial mutation: small changes that stay within the bounds."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace, Mutation, RealSpace, option
from gaitsim.portable import power
from gaitsim_operators.mutation.sites import draw_sites
from gaitsim_operators.spaces import real_space


class Polynomial(Mutation):
    """Moves each gene by a polynomially distributed step, with a given probability.

    Deb and Agrawal 1999, in the form with bounds: a gene near a bound takes shorter steps towards
    it. Periodic genes have no bounds, so their steps are equally long in both directions.
    """

    rate: float = option(0.05, "probability that a gene mutates", ge=0, le=1)
    eta: float = option(20.0, "distribution index; larger values make steps shorter", ge=0, le=1000)

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of genomes, (population, genes) float64."""
        bounds = real_space(space)
        mutants = genomes.copy()
        sites = draw_sites(genomes.size, self.rate, rng)
        gene = sites % space.genes
        width = bounds.width[gene]
        below = (genomes.reshape(-1)[sites] - bounds.lower[gene]) / width
        above = 1 - below
        if bounds.periodic is not None:
            periodic = bounds.periodic[gene]
            below[periodic] = above[periodic] = 1
        steps = _steps(below, above, rng.random(len(sites)), self.eta)
        mutants.reshape(-1)[sites] += steps * width
        return mutants


def _steps(
    below: NDArray[np.float64],
    above: NDArray[np.float64],
    uniform: NDArray[np.float64],
    eta: float,
) -> NDArray[np.float64]:
    """Return steps, (sites,), as fractions of the distance between the bounds.

    Args:
        below: distance from the lower bound to the gene, in the same unit, (sites,).
        above: distance from the gene to the upper bound, in the same unit, (sites,). A gene that
            crossover moved beyond a bound has no room on that side, and 1 on the other.
        uniform: draws from [0, 1), (sites,).
        eta: distribution index.
    """
    downwards = uniform <= 0.5
    room = np.clip(np.where(downwards, below, above), 0, 1)
    # Nearness of the draw to the middle of its range, from 0 at both ends to 1 in the middle.
    near = np.where(downwards, 2 * uniform, 2 * (1 - uniform))
    length = 1 - power(near + (1 - near) * power(1 - room, eta + 1), 1 / (eta + 1))
    return np.where(downwards, -length, length)
