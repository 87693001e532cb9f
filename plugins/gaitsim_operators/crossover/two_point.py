"""Two-point crossover: two cuts."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace
from gaitsim_operators.crossover.exchange import after_cuts, exchange
from gaitsim_operators.draws import distinct_pairs


class TwoPoint(Crossover):
    """Takes the father's genes between two cuts, and the mother's genes on both sides.

    De Jong 1975. A second child gets the other genes. The two cuts differ, and all pairs of cuts
    are equally likely.
    """

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each.

        Two genes have room for only one cut, so the second comes from the father. A single gene
        comes from the mother.
        """
        pairs, genes = mothers.shape
        if genes < 3:
            return exchange(mothers, fathers, np.arange(genes) >= 1, self.children)
        one, other = distinct_pairs(genes - 1, (pairs, 1), rng)
        # Genes between the cuts are past exactly one of them, in either order of the cuts.
        return exchange(
            mothers,
            fathers,
            after_cuts(one + 1, genes) != after_cuts(other + 1, genes),
            self.children,
        )
