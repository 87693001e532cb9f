"""Reset mutation: replaces genes by random ones."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation, option
from gaitsim_operators.mutation.sites import draw_sites


class Reset(Mutation):
    """Replaces each gene by a random one, with a given probability.

    New genes are drawn as in the initial population. Eiben and Smith 2015, section 4.3, call it
    random resetting.
    """

    rate: float = option(0.05, "probability that a gene is replaced", ge=0, le=1)

    portable: ClassVar[bool] = True

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of genomes, (population, genes), with the same dtype."""
        mutants = genomes.copy()
        sites = draw_sites(genomes.size, self.rate, rng)
        mutants.reshape(-1)[sites] = space.random(len(genomes), rng).reshape(-1)[sites]
        return mutants
