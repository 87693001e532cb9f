"""No crossover: children are copies."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace


class NoCrossover(Crossover):
    """Passes parents on unchanged, for schemes that breed by mutation alone.

    Of two children, the first is a copy of the mother, the second of the father.
    """

    pair_probability: ClassVar[float] = 1.0  # type: ignore[misc]  # no option: it crosses no pair

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """(pairs, genes) twice -> (pairs × children, genes)."""
        return mothers.copy() if self.children == 1 else np.concatenate((mothers, fathers))
