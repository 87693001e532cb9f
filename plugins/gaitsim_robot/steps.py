"""Step cycles: paths of feet in the trunk's frame, and joint angles that follow them."""

import math

import numpy as np

from gaitsim.portable import sin
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.chain import Chain

SAMPLES = 32  # samples per cycle; joint angles between them are interpolated
ITERATIONS = 12
SLOWEST_RETURN = -0.5  # stride lengths per swing, lower bound of the speed at the ends of a swing


def foot_path(phase: Floats, duty: Floats) -> tuple[Floats, Floats]:
    """Return the forward position of a foot, in strides, and its height, in lifts.

    In stance, the foot moves backward at constant speed. In swing, its position follows a cubic
    with almost that speed at both ends, so that the foot lands with little slip, and its height
    follows a squared sine.

    Args:
        phase: phase of the cycle from 0, the start of stance, to 1, (..., samples).
        duty: share of the cycle in stance, (..., 1).
    """
    swing = np.clip((phase - duty) / (1 - duty), 0.0, 1.0)
    slope = np.maximum(-(1 - duty) / duty, SLOWEST_RETURN)
    cubic = swing * swing * (3 - 2 * swing) - 0.5
    cubic = cubic + slope * swing * (1 - swing) * (1 - 2 * swing)
    ahead = np.where(phase < duty, 0.5 - phase / duty, cubic)
    return np.asarray(ahead), np.square(sin(math.pi * swing))


def cycle_angles(chain: Chain, targets: Floats, level: bool) -> Floats:
    """Return joint angles that move a leg's foot to the targets, or close to them.

    Args:
        chain: chain of the leg; its pose `zero` is the standing pose.
        targets: positions of the foot in the standing trunk's frame, (population, SAMPLES, 3) m.
        level: whether the foot keeps its orientation as far as its joints allow.

    Returns:
        The angles, (population, SAMPLES, joints) rad.
    """
    weights = chain.weights(level)
    return chain.solve(targets, chain.zero, chain.zero, weights, ITERATIONS)


def fastest_turn(angles: Floats) -> Floats:
    """Return the largest speed of each joint in cycles, (population, joints) rad per cycle."""
    fastest: Floats = np.abs(np.diff(angles, axis=1, append=angles[:, :1])).max(axis=1)
    return fastest * SAMPLES


def interpolate_cycle(angles: Floats, phase: Floats) -> Floats:
    """Return the angles of a cycle at any phase, interpolated with periodic cubics.

    Source: E. Catmull, R. Rom, A class of local interpolating splines (1974).

    Args:
        angles: angles of a cycle, (population, SAMPLES, joints) rad.
        phase: phase in cycles, (population, frames).

    Returns:
        The angles, (population, frames, joints) rad.
    """
    place = (phase - np.floor(phase)) * SAMPLES
    first = np.minimum(place.astype(np.intp), SAMPLES - 1)
    t = (place - first)[..., None]
    individuals = np.arange(len(angles))[:, None]
    a, b, c, d = (angles[individuals, (first + shift) % SAMPLES] for shift in (-1, 0, 1, 2))
    between: Floats = b + 0.5 * t * (
        c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))
    )
    return between
