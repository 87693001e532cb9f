"""Open-loop oscillators, one for each joint.

Source: Raffin, Sigaud, Kober, Albu-Schäffer, Silvério and Stulp 2024, "An open-loop baseline for
reinforcement learning locomotion tasks".
"""

import math

import numpy as np

from gaitsim.plugin import Array, Genomes, RealSpace
from gaitsim.plugin.toolkit import sin
from gaitsim_gymnasium.environments import Limits

FASTEST = 4.0  # Hz
SHARED = ("swing frequency (Hz)", "stance frequency (Hz)")


def oscillator_space(joints: int) -> RealSpace:
    """Return the space of two frequencies, and of amplitude, phase and offset of each joint."""
    lower = [0.2, 0.2, *[0.0, 0.0, -1.0] * joints]
    upper = [FASTEST, FASTEST, *[1.5, math.tau, 1.0] * joints]
    labels = [f"{name} {n}" for n in range(joints) for name in ("amplitude", "phase", "offset")]
    periodic = [False, False, *[False, True, False] * joints]
    return RealSpace(
        np.array(lower), np.array(upper), (*SHARED, *labels), periodic=np.array(periodic)
    )


def oscillations(genomes: Genomes, limits: Limits) -> Array:
    """Return the angle that each oscillator wants, (population, steps, joints) rad.

    The angle is a · sin(θ + φ) + b; θ advances at the frequency of the swing while the sine is
    positive, and otherwise at that of the stance.
    """
    swing, stance = math.tau * genomes[:, 0, None], math.tau * genomes[:, 1, None]
    own = genomes[:, 2:].reshape(len(genomes), -1, 3)
    amplitude, phase, offset = own[..., 0], own[..., 1], own[..., 2]
    angle = np.zeros_like(phase)
    found = np.empty((len(genomes), limits.steps, limits.actions))
    for step in range(limits.steps):
        wave = sin(angle + phase)
        found[:, step] = amplitude * wave + offset
        angle += np.where(wave > 0, swing, stance) / limits.frame_rate
    return found
