"""Polynomial mutation: small changes that stay between the bounds."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace, Mutation, RealSpace, option
from gaitsim_operators.mutation.sites import draw_sites
from gaitsim_operators.real import real


class Polynomial(Mutation):
    """Moves each gene with a probability by a polynomially distributed step.

    Deb and Agrawal 1999, the form with bounds, in which a gene near a bound
    takes shorter steps towards it. Genes of a cycle have no bounds, so they
    may step as far either way.
    """

    rate: float = option(0.05, "probability that a gene mutates", ge=0, le=1)
    eta: float = option(
        20.0, "distribution index: the greater, the shorter the steps", ge=0, le=1000
    )

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """(population, genes) -> mutants of that shape, float64.

        Raises:
            PluginError: the space is not of real numbers.
        """
        bounds = real(space)
        mutants = genomes.copy()
        sites = draw_sites(genomes.size, self.rate, rng)
        gene = sites % space.genes
        width = bounds.width[gene]
        below = (genomes.reshape(-1)[sites] - bounds.lower[gene]) / width
        above = 1 - below
        if bounds.periodic is not None:
            free = bounds.periodic[gene]
            below[free] = above[free] = 1
        steps = _steps(below, above, rng.random(len(sites)), self.eta)
        mutants.reshape(-1)[sites] += steps * width
        return mutants


def _steps(
    below: NDArray[np.float64],
    above: NDArray[np.float64],
    uniform: NDArray[np.float64],
    eta: float,
) -> NDArray[np.float64]:
    """Steps in widths of the bounds, (sites,).

    Args:
        below: room between gene and lower bound, in widths, (sites,).
        above: room between gene and upper bound, likewise. A gene that crossover left
            outside has no room on that side and all of it on the other.
        uniform: draws from [0, 1), (sites,).
        eta: distribution index.
    """
    downwards = uniform <= 0.5
    room = np.clip(np.where(downwards, below, above), 0, 1)
    # How near the draw is to the middle, from 0 at both ends of its range to 1.
    near = np.where(downwards, 2 * uniform, 2 * (1 - uniform))
    length = 1 - (near + (1 - near) * (1 - room) ** (eta + 1)) ** (1 / (eta + 1))
    return np.where(downwards, -length, length)
