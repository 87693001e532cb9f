"""No crossover: children are copies."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace


class NoCrossover(Crossover):
    """Copies parents unchanged, for schemes that breed by mutation alone.

    With two children, the first is a copy of the mother and the second of the father.
    """

    portable: ClassVar[bool] = True
    pair_probability: ClassVar[float] = 1.0  # type: ignore[misc]  # not an option of this class

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return copies, (pairs × children, genes), of parents, (pairs, genes) each."""
        return mothers.copy() if self.children == 1 else np.concatenate((mothers, fathers))
