"""No mutation: genomes stay as they are."""

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class NoMutation(Mutation):
    """Passes genomes on unchanged, for schemes that breed by crossover alone."""

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """(population, genes) -> a copy."""
        return genomes.copy()
