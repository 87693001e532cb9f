"""Random search: fresh genomes in each generation, as a baseline to compare with."""

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class RandomSearch(Mutation):
    """Random search: replaces every genome by a fresh one."""

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """(population, genes) -> fresh genomes of that shape and dtype."""
        return space.random(len(genomes), rng)
