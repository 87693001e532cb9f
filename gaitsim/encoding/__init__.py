"""Encodings: how a genome becomes joint angles over time, for any number of joints.

A body declares groups of genes (`GeneGroup`), builds its genome space from them
(`genome_space`), and decodes a population in two steps: `split_genomes` returns the values of
each group, and `sine` or `cpg` turns amplitudes, phases and lags into joint angles.

Every oscillator drives one or more joints, usually those of one leg. `oscillators` names the
oscillator of each joint by its index, (joints,). Frequencies are in Hz, angles in radians.
"""

from gaitsim.encoding.cpg import cpg
from gaitsim.encoding.genes import GeneGroup, genome_space, split_genomes
from gaitsim.encoding.limits import amplitude_limit, check_joint_angles, limit_steps
from gaitsim.encoding.sine import sine

__all__ = [
    "GeneGroup",
    "amplitude_limit",
    "check_joint_angles",
    "cpg",
    "genome_space",
    "limit_steps",
    "sine",
    "split_genomes",
]
