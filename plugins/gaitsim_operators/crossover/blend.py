"""Blend crossover, BLX-α: genes between the parents' genes, or slightly beyond."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, RealSpace, option
from gaitsim.portable import uniform
from gaitsim_operators.crossover.differences import parent_differences
from gaitsim_operators.spaces import real_space


class Blend(Crossover):
    """Draws each gene of a child uniformly between its parents' genes, extended by α on both sides.

    BLX-α, Eshelman and Schaffer 1993. With α = 0.5, the spread of genes neither shrinks nor grows
    much from generation to generation. Children are drawn independently. Periodic genes lie between
    their parents on the shorter way round.
    """

    alpha: float = option(
        0.5, "extension beyond the parents, as a share of their distance", ge=0, le=10
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes) float64, of parents, (pairs, genes) each."""
        difference = parent_differences(mothers, fathers, real_space(space))
        share = uniform(rng, -self.alpha, 1 + self.alpha, (self.children, *difference.shape))
        return (mothers + share * difference).reshape(-1, difference.shape[1])
