"""Encodings, which turn genomes into joint angles over time, for any number of joints.

A body declares groups of genes (`GeneGroup`), builds its genome space from them
(`genome_space`), and decodes a population in two steps: `split_genomes` returns the values of
each group, and `Oscillators.sine` or `Oscillators.cpg` converts them to joint angles.
"""

from gaitsim.encoding.genes import GeneGroup, genome_space, split_genomes
from gaitsim.encoding.limits import (
    amplitude_limit,
    check_joint_angles,
    check_time_step,
    limit_steps,
)
from gaitsim.encoding.oscillators import Oscillators

__all__ = [
    "GeneGroup",
    "Oscillators",
    "amplitude_limit",
    "check_joint_angles",
    "check_time_step",
    "genome_space",
    "limit_steps",
    "split_genomes",
]
