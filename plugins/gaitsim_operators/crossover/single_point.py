"""Single-point crossover: one cut."""

from typing import ClassVar, Literal

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, option
from gaitsim_operators.crossover.exchange import after_cuts, exchange


class SinglePoint(Crossover):
    """Takes the mother's genes before a cut and the father's genes after it.

    Holland 1975. A second child gets the other genes.
    """

    children: Literal[1, 2] = option(1, "number of children of each pair of parents")
    point: Literal["random", "half"] = option(
        "random",
        "position of the cut: 'random' draws it for each pair, 'half' always cuts in the middle",
    )

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each.

        A single gene comes from the mother.
        """
        pairs, genes = mothers.shape
        if genes == 1:
            cuts = np.ones((pairs, 1), dtype=np.int64)
        elif self.point == "half":
            cuts = np.full((pairs, 1), genes // 2)
        else:
            cuts = rng.integers(1, genes, (pairs, 1))
        return exchange(mothers, fathers, after_cuts(cuts, genes), self.children)
