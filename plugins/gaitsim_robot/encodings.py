"""How a genome becomes joint angles."""

import math

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.encoding import GeneGroup, Oscillators, split_genomes
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.world import FRAME_RATE


def groups(anatomy: Anatomy) -> tuple[GeneGroup, ...]:
    """Return the groups of genes: amplitude and phase a joint, and the frequency."""
    joints = anatomy.joints
    return (
        GeneGroup("amplitude", joints, 0.0, 0.4),
        GeneGroup("phase", joints, -math.pi, math.pi, periodic=True),
        GeneGroup("frequency", ("",), 0.5, 2.5),
    )


def commands(
    anatomy: Anatomy, rest: Floats, genomes: Genomes, genes: tuple[GeneGroup, ...], frames: int
) -> Floats:
    """Return the commands to the servos, (population, frames, joints) rad."""
    amplitude, phase, frequency = split_genomes(genomes, genes)
    oscillators = Oscillators(np.arange(len(anatomy.joints)), frames, FRAME_RATE)
    angles = oscillators.sine(amplitude, phase, np.zeros_like(phase), frequency[:, 0])
    ramp = np.minimum(np.arange(frames) / FRAME_RATE, 1.0)
    return rest + (angles * ramp).swapaxes(1, 2)
