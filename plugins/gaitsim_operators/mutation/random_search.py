"""Random search: new random genomes in each generation, as a baseline for comparisons."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class RandomSearch(Mutation):
    """Random search: replaces every genome by a random one."""

    portable: ClassVar[bool] = True

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return random genomes, (population, genes), as many as `genomes`."""
        return space.random(len(genomes), rng)
