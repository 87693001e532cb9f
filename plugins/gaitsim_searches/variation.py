"""Variation of elites: mutation, and recombination with other elites."""

import numpy as np

from gaitsim.contracts import Genomes, RealSpace
from gaitsim.portable import standard_normal
from gaitsim_searches.real import differences


def mutate_all_genes(
    genomes: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Add a normally distributed change to every gene; `sigma` is in widths of the bounds."""
    return genomes + sigma * space.width * standard_normal(rng, genomes.shape)


def line_shifts(
    genomes: Genomes, others: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Return a shift of each genome along the line to another genome.

    The shift, as a share of the distance, is normal with standard deviation `sigma`. Periodic genes
    take the shorter way round. Vassiliades and Mouret 2018, "Discovering the elite hypervolume by
    leveraging interspecies correlation".
    """
    shift: Genomes = differences(others, genomes, space)
    return shift * (sigma * standard_normal(rng, (len(genomes), 1)))


def flip_bits(genomes: Genomes, flips: float, rng: np.random.Generator) -> Genomes:
    """Flip `flips` bits of each genome on average."""
    flip = rng.random(genomes.shape) * genomes.shape[1] < flips
    return np.where(flip, 1 - genomes, genomes)


def uniform_crossover(genomes: Genomes, others: Genomes, rng: np.random.Generator) -> Genomes:
    """Take each bit from one of two genomes at random (Syswerda 1989)."""
    return np.where(rng.random(genomes.shape) < 0.5, genomes, others)
