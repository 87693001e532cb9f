"""Uniform crossover: each gene independently from either parent."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, option
from gaitsim_operators.crossover.exchange import exchange


class Uniform(Crossover):
    """Takes each gene from the father with a given probability, otherwise from the mother.

    Syswerda 1989; with a probability other than one half, Spears and De Jong 1991. A second child
    gets the other genes.
    """

    probability: float = option(
        0.5, "probability that a gene is exchanged between the parents", ge=0, le=1
    )

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each."""
        swapped = rng.random(mothers.shape) < self.probability
        return exchange(mothers, fathers, swapped, self.children)
