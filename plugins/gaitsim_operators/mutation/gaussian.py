"""Gaussian mutation: small random changes."""

from typing import ClassVar, Self

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Mutation, RealSpace, option
from gaitsim.portable import power, standard_normal
from gaitsim_operators.mutation.sites import draw_sites
from gaitsim_operators.spaces import real_space


class Gaussian(Mutation):
    """Adds a normally distributed change to each gene with a given probability.

    Hinterding 1995 for genes of a genetic algorithm, after Rechenberg 1973.
    """

    rate: float = option(0.05, "probability that a gene mutates", ge=0, le=1)
    sigma: float = option(
        0.1, "standard deviation of a change, as a share of the gene's range", gt=0, le=10
    )
    decay: float = option(
        1.0,
        "factor applied to 'sigma' after each generation; 1 keeps 'sigma' constant",
        gt=0,
        le=1,
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def at(self, generation: int) -> Self:
        """Return the mutation with the decayed sigma of `generation`."""
        if self.decay == 1:
            return self
        return self.model_copy(update={"sigma": self.sigma * float(power(self.decay, generation))})

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of genomes, (population, genes) float64."""
        deviation = self.sigma * real_space(space).width
        mutants = genomes.copy()
        sites = draw_sites(genomes.size, self.rate, rng)
        changes = standard_normal(rng, len(sites)) * deviation[sites % space.genes]
        mutants.reshape(-1)[sites] += changes
        return mutants
