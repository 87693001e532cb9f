"""Simulated binary crossover, SBX: spreads real genes as single-point crossover spreads bits."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, RealSpace, option
from gaitsim.portable import power
from gaitsim_operators.crossover.differences import parent_differences
from gaitsim_operators.spaces import real_space


class SimulatedBinary(Crossover):
    """Places two children symmetrically about the middle of their parents, mostly near the parents.

    SBX, Deb and Agrawal 1995, without bounds. For each gene, a random child gets the lower value,
    as in Deb's own programs; otherwise each child would nearly copy one parent. Those programs
    cross half of the genes of a pair: `gene_probability = 0.5`. The middle of periodic genes is on
    the shorter way round.
    """

    eta: float = option(
        15.0,
        "distribution index; larger values keep children closer to their parents",
        ge=0,
        le=1000,
    )

    gene_probability: float = option(
        1.0,
        "probability that a gene of a crossed pair is crossed; otherwise each child inherits the "
        "gene of one parent",
        ge=0,
        le=1,
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes) float64, of parents, (pairs, genes) each.

        The mean of both children equals the mean of their parents. With one child per pair, the
        second is dropped.
        """
        difference = parent_differences(mothers, fathers, real_space(space))
        # One draw gives the side, by the half of its range, and the position in that half.
        draws = 2 * rng.random(difference.shape)
        swapped = draws >= 1
        spread = _spread_factor(draws - swapped, self.eta)
        part = (1 - np.where(swapped, -spread, spread)) / 2
        children = [mothers + share * difference for share in (part, 1 - part)[: self.children]]
        if self.gene_probability < 1:
            kept = rng.random(difference.shape) >= self.gene_probability
            for child, parents in zip(children, (mothers, fathers), strict=False):
                np.copyto(child, parents, where=kept)
        return np.concatenate(children)


def _spread_factor(uniform: NDArray[np.float64], eta: float) -> NDArray[np.float64]:
    """Return the children's distance relative to the parents' distance, for draws from [0, 1)."""
    base = np.where(uniform <= 0.5, 2 * uniform, 0.5 / (1 - uniform))
    return power(base, 1 / (eta + 1))
