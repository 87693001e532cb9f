"""Blend crossover, BLX-α: anywhere between the parents, and somewhat beyond."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, RealSpace, option
from gaitsim_operators.crossover.gap import gap
from gaitsim_operators.real import real


class Blend(Crossover):
    """Each gene of a child is uniform between its parents', widened by α on both sides.

    BLX-α, Eshelman and Schaffer 1993. With α = 0.5 the spread of genes neither
    shrinks nor grows much from one generation to the next. Children are
    independent. Periodic genes lie between their parents the shorter way round.
    """

    alpha: float = option(
        0.5, "how far children may lie beyond their parents, in parents' distances", ge=0, le=10
    )

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """(pairs, genes) twice -> (pairs × children, genes) float64.

        Raises:
            PluginError: the space is not of real numbers.
        """
        way = gap(mothers, fathers, real(space))
        part = rng.uniform(-self.alpha, 1 + self.alpha, (self.children, *way.shape))
        return (mothers + part * way).reshape(-1, way.shape[1])
