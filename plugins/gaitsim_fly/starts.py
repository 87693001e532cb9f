"""Start states of the fly's trials."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import cos, norm, sin, uniform
from gaitsim_fly.flight import MOMENTUM, POSITION, ROTATION, STATE, VELOCITY


def starts(
    trials: int,
    seed: int,
    inertia: NDArray[np.float64],
    *,
    offset: float,
    tilt: float,
    headings: NDArray[np.float64],
    speed: float,
    spin: float,
    planar: bool,
) -> NDArray[np.float64]:
    """Return the state at the start of each trial, (trials, STATE); the first is level, at rest.

    Args:
        trials: number of trials.
        seed: seed of the other states, which are drawn uniformly along each axis.
        inertia: moments of inertia, (3,) kg·m².
        offset: largest distance from the origin along each axis, m.
        tilt: largest component of the rotation vector, rad.
        headings: headings of the trials, (trials,) rad.
        speed: largest speed along each axis, m/s.
        spin: largest angular speed about each axis, rad/s.
        planar: whether to draw only symmetric starts, as wings with equal commands cannot correct
            asymmetric ones.
    """
    states = np.zeros((trials, STATE))
    states[:, ROTATION] = 1.0
    draws = uniform(np.random.default_rng(seed), -1, 1, (trials - 1, 4, 3))
    if planar:
        draws[:, (0, 2), 1] = 0.0  # sideways position and velocity
        draws[:, 1::2, ::2] = 0.0  # roll and yaw
    turn = tilt * draws[:, 1]
    half = norm(turn)[:, None] / 2
    states[1:, POSITION : POSITION + 3] = offset * draws[:, 0]
    states[1:, ROTATION : ROTATION + 1] = cos(half)
    # sin(half) / half, which tends to 1
    ratio = np.where(half > 0, sin(half), 1.0) / np.where(half > 0, half, 1.0)
    states[1:, ROTATION + 1 : ROTATION + 4] = turn / 2 * ratio
    states[:, ROTATION : ROTATION + 4] = _turn_about_vertical(
        states[:, ROTATION : ROTATION + 4], headings / 2
    )
    states[1:, VELOCITY : VELOCITY + 3] = speed * draws[:, 2]
    momentum = inertia * (spin * draws[:, 3])  # in the frame of the body
    states[1:, MOMENTUM : MOMENTUM + 3] = _rotate(states[1:, ROTATION : ROTATION + 4], momentum)
    return states


def headings(trials: int, seed: int, largest: float) -> NDArray[np.float64]:
    """Return the heading of each trial, (trials,) rad: 0 for the first, random for the others."""
    drawn = uniform(np.random.default_rng([seed, 1]), -1, 1, trials - 1)
    return np.concatenate([[0.0], largest * drawn])


def _turn_about_vertical(
    quaternions: NDArray[np.float64], half: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Turn attitudes about the vertical by twice the angles `half`, (trials,) rad."""
    w, x, y, z = quaternions.T
    c, s = cos(half), sin(half)
    return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=1)


def _rotate(quaternions: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotate vectors, (trials, 3), by unit quaternions, (trials, 4)."""
    w, u = quaternions[:, :1], quaternions[:, 1:]
    cross = np.cross(u, vectors)
    result: NDArray[np.float64] = vectors + 2 * (w * cross + np.cross(u, cross))
    return result
