"""Variation of elites: mutation, and recombination with other elites."""

import numpy as np

from gaitsim.contracts import Genomes, RealSpace
from gaitsim_searches.real import differences


def isotropic(
    genomes: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Add a normal change to every gene; `sigma` is in widths of its bounds."""
    return genomes + sigma * space.width * rng.standard_normal(genomes.shape)


def along_lines(
    genomes: Genomes, others: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Return a change of each genome along the line to another genome.

    Its share of their distance is normal with standard deviation `sigma`. Periodic genes take the
    shorter way round. Vassiliades and Mouret 2018, "Discovering the elite hypervolume by leveraging
    interspecies correlation".
    """
    shift: Genomes = differences(others, genomes, space)
    return shift * (sigma * rng.standard_normal((len(genomes), 1)))


def flipped(genomes: Genomes, flips: float, rng: np.random.Generator) -> Genomes:
    """Flip `flips` bits of each genome on average."""
    flip = rng.random(genomes.shape) * genomes.shape[1] < flips
    return np.where(flip, 1 - genomes, genomes)


def mixed(genomes: Genomes, others: Genomes, rng: np.random.Generator) -> Genomes:
    """Take each bit from either genome at random: uniform crossover (Syswerda 1989)."""
    return np.where(rng.random(genomes.shape) < 0.5, genomes, others)
