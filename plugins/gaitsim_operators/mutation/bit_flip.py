"""Bit-flip mutation: a fixed number of bits of every genome."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import BitSpace, Genomes, GenomeSpace, Mutation, option


class BitFlip(Mutation):
    """Flips a fixed number of different bits of every genome.

    Unlike a rate for each bit, it leaves no genome unchanged. Where genomes
    have fewer bits, all are flipped.
    """

    count: int = option(1, "how many bits of every genome are flipped", ge=1, le=100_000)

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (BitSpace,)

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """(population, genes) -> mutants of that shape, uint8."""
        population, genes = genomes.shape
        flips = np.zeros(population * genes, genomes.dtype)
        starts = np.arange(0, len(flips), genes)
        # Floyd's sample (Bentley and Floyd 1987), for all genomes in step: a bit
        # drawn again stands for the newest of those that may be drawn.
        for newest in range(genes - min(self.count, genes), genes):
            drawn = starts + rng.integers(0, newest + 1, population)
            flips[np.where(flips.take(drawn), starts + newest, drawn)] = 1
        return genomes ^ flips.reshape(genomes.shape)
