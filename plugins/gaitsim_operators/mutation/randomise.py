"""Randomise: every genome begins anew."""

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation


class Randomise(Mutation):
    """Replaces every genome by a fresh one: random search, to compare others with."""

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """(population, genes) -> fresh genomes of that shape and dtype."""
        return space.random(len(genomes), rng)
