"""No mutation: genomes stay unchanged."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class NoMutation(Mutation):
    """Copies genomes unchanged, for schemes that breed by crossover alone."""

    portable: ClassVar[bool] = True

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return a copy of genomes, (population, genes)."""
        return genomes.copy()
