"""How commands reach servos: held between those that are sent, and late."""

import numpy as np
from numpy.typing import NDArray

Angles = NDArray[np.float64]
"""(…, frames, joints), radians."""


def held(commands: Angles, frame_rate: float, rate: float, steps: int = 1) -> Angles:
    """Return the commands in force in each step, from a controller that sends them at a rate.

    What it sends is the gait at that moment, interpolated between frames.

    Args:
        commands: (…, frames, joints) rad.
        frame_rate: of the frames, Hz.
        rate: at which commands are sent, Hz; at the frame rate, each frame's are held to the bit.
        steps: number of steps a frame.

    Returns:
        (…, frames · steps, joints) rad.
    """
    return in_force(commands, np.arange(commands.shape[-2] * steps) / steps, frame_rate / rate)


def in_force(commands: Angles, moments: NDArray[np.float64], apart: float) -> Angles:
    """Return the commands in force at some moments, from a controller as in `held`.

    Args:
        commands: (…, frames, joints) rad.
        moments: (moments,) frames.
        apart: time from one command to the next, frames.

    Returns:
        (…, moments, joints) rad.
    """
    # Without the allowance, rounding would send some commands a step late.
    sent = np.floor(moments / apart + 1e-9) * apart
    before = sent.astype(np.intp)
    after = np.minimum(before + 1, commands.shape[-2] - 1)
    here, there = commands[..., before, :], commands[..., after, :]
    return np.asarray(here + (sent - before)[:, None] * (there - here))


def delayed(angles: Angles, steps: NDArray[np.floating | np.integer] | float) -> Angles:
    """Delay joint angles, interpolated between steps; a joint holds its first angle until then.

    Args:
        angles: (…, steps, joints) rad.
        steps: by how many, one number or (joints,), at least 0; whole numbers keep the bits.
    """
    count, joints = angles.shape[-2:]
    late = np.broadcast_to(np.asarray(steps, np.float64), joints)
    whole = np.floor(late)
    after = np.maximum(np.arange(count)[:, None] - whole.astype(np.intp), 0)
    column = np.arange(joints)
    here, there = angles[..., after, column], angles[..., np.maximum(after - 1, 0), column]
    return np.asarray(here + (late - whole) * (there - here))
