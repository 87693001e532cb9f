"""Step cycles: paths of feet in the trunk's frame, and the joint angles that follow them."""

import math

import numpy as np

from gaitsim_robot.anatomy import Floats
from gaitsim_robot.chain import Chain

SAMPLES = 32  # of a cycle; joint angles between them are interpolated
ITERATIONS = 12
SLOWEST_RETURN = -0.5  # stride lengths a swing: bound of the speed at both ends of a swing


def path(phase: Floats, duty: Floats) -> tuple[Floats, Floats]:
    """Return how far ahead a foot is, in strides, and how high, in lifts.

    The foot moves backward at an even speed in stance. In swing it follows a cubic whose ends
    move backward nearly at that speed, so that it lands with little slip, and rises by a sine
    squared.

    Args:
        phase: of the cycle, (..., samples), from 0, where stance begins, to 1.
        duty: share of the cycle in stance, (..., 1).
    """
    swing = np.clip((phase - duty) / (1 - duty), 0.0, 1.0)
    slope = np.maximum(-(1 - duty) / duty, SLOWEST_RETURN)
    cubic = swing * swing * (3 - 2 * swing) - 0.5
    cubic = cubic + slope * swing * (1 - swing) * (1 - 2 * swing)
    ahead = np.where(phase < duty, 0.5 - phase / duty, cubic)
    return np.asarray(ahead), np.sin(math.pi * swing) ** 2


def cycle(chain: Chain, targets: Floats, level: bool) -> Floats:
    """Return the joint angles of a leg whose foot is at the targets or near them.

    Args:
        chain: of the leg; all at `zero` is the standing pose.
        targets: of the foot in the standing trunk's frame, (population, SAMPLES, 3) m.
        level: whether the foot keeps its orientation as far as its joints allow.

    Returns:
        (population, SAMPLES, joints) rad.
    """
    weights = chain.weights(level)
    return chain.solve(targets, chain.zero, chain.zero, weights, ITERATIONS)


def fastest_turn(angles: Floats) -> Floats:
    """Return how fast each joint turns at most in such cycles, (population, joints) rad a cycle."""
    fastest: Floats = np.abs(np.diff(angles, axis=1, append=angles[:, :1])).max(axis=1)
    return fastest * SAMPLES


def interpolated(angles: Floats, phase: Floats) -> Floats:
    """Return the angles of a cycle at any phases by periodic cubics.

    Source: E. Catmull, R. Rom, A class of local interpolating splines (1974).

    Args:
        angles: (population, SAMPLES, joints) rad.
        phase: cycles, (population, frames).

    Returns:
        (population, frames, joints) rad.
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
