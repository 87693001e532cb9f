"""Uniform crossover: each gene for itself."""

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, option
from gaitsim_operators.crossover.exchange import exchange


class Uniform(Crossover):
    """Each gene is the father's with a probability, else the mother's.

    Syswerda 1989; with a probability other than one half, Spears and De Jong
    1991. The second child, if wanted, has the others.
    """

    probability: float = option(
        0.5, "probability that a gene is exchanged between the parents", ge=0, le=1
    )

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """(pairs, genes) twice -> (pairs × children, genes)."""
        swapped = rng.random(mothers.shape) < self.probability
        return exchange(mothers, fathers, swapped, self.children)
