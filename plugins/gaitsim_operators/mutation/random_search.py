"""Random search: new random genomes in each generation, as a baseline for comparisons."""

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class RandomSearch(Mutation):
    """Random search: replaces every genome by a random one."""

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return random genomes, (population, genes), as many as `genomes`."""
        return space.random(len(genomes), rng)
