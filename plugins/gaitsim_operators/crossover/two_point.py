"""Two-point crossover: two cuts."""

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace
from gaitsim_operators.crossover.exchange import exchange, past
from gaitsim_operators.draws import two_different


class TwoPoint(Crossover):
    """A child has its father's genes between two cuts, its mother's on both sides.

    De Jong 1975. The second child, if wanted, has the others. The two cuts
    differ, and any two are equally likely.
    """

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """(pairs, genes) twice -> (pairs × children, genes).

        Two genes have room for one cut, so the second is the father's; one gene
        alone is the mother's.
        """
        pairs, genes = mothers.shape
        if genes < 3:
            return exchange(mothers, fathers, np.arange(genes) >= 1, self.children)
        one, other = two_different(genes - 1, (pairs, 1), rng)
        # Between the cuts lies what is past one of them alone, whichever comes first.
        return exchange(
            mothers, fathers, past(one + 1, genes) != past(other + 1, genes), self.children
        )
