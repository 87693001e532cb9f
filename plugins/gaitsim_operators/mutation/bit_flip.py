"""Bit-flip mutation: flips a fixed number of bits of every genome."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import BitSpace, Genomes, GenomeSpace, Mutation, option


class BitFlip(Mutation):
    """Flips a fixed number of different bits of every genome.

    Unlike a mutation with a rate per bit, it leaves no genome unchanged. If genomes have fewer
    bits than `count`, all bits are flipped.
    """

    count: int = option(1, "number of bits flipped in every genome", ge=1, le=100_000)

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (BitSpace,)

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of genomes, (population, genes) uint8."""
        population, genes = genomes.shape
        flips = np.zeros(population * genes, genomes.dtype)
        starts = np.arange(0, len(flips), genes)
        # Floyd's sampling (Bentley and Floyd 1987) for all genomes together: if a drawn bit was
        # drawn before, the newest candidate is flipped instead.
        for newest in range(genes - min(self.count, genes), genes):
            drawn = starts + rng.integers(0, newest + 1, population)
            flips[np.where(flips.take(drawn), starts + newest, drawn)] = 1
        return genomes ^ flips.reshape(genomes.shape)
