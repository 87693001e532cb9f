"""Single-point crossover: one cut."""

from typing import Literal

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, option
from gaitsim_operators.crossover.exchange import exchange, past


class SinglePoint(Crossover):
    """A child has its mother's genes up to a cut, its father's from there.

    Holland 1975. The second child, if wanted, has the others.
    """

    children: Literal[1, 2] = option(1, "how many children each pair of parents has")
    point: Literal["random", "half"] = option(
        "random", "where genomes are cut: drawn for each pair, or always in half"
    )

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """(pairs, genes) twice -> (pairs × children, genes); one gene alone is the mother's."""
        pairs, genes = mothers.shape
        if genes == 1:
            cuts = np.ones((pairs, 1), dtype=np.int64)
        elif self.point == "half":
            cuts = np.full((pairs, 1), genes // 2)
        else:
            cuts = rng.integers(1, genes, (pairs, 1))
        return exchange(mothers, fathers, past(cuts, genes), self.children)
