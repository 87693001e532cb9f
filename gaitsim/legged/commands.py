"""How commands reach servos: held between those that are sent, and late."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_Float = TypeVar("_Float", bound=np.floating[Any])


def held(
    commands: NDArray[_Float], frame_rate: float, rate: float, steps: int = 1
) -> NDArray[_Float]:
    """Return the commands in force in each step, from a controller that sends them at a rate.

    What it sends is the gait at that moment, interpolated between frames.

    Args:
        commands: (…, frames, joints) rad.
        frame_rate: of the frames, Hz.
        rate: at which commands are sent, Hz; at the frame rate, each frame's are held to the bit.
        steps: number of steps a frame.

    Returns:
        (…, frames · steps, joints) rad, in the dtype of `commands`.
    """
    return in_force(commands, np.arange(commands.shape[-2] * steps) / steps, frame_rate / rate)


def in_force(
    commands: NDArray[_Float], moments: NDArray[np.float64], apart: float
) -> NDArray[_Float]:
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
    return _between(commands[..., before, :], commands[..., after, :], (sent - before)[:, None])


def delayed(angles: NDArray[_Float], steps: NDArray[Any] | float) -> NDArray[_Float]:
    """Delay joint angles, interpolated between steps; a joint holds its first angle until then.

    Args:
        angles: (…, steps, joints) rad.
        steps: by how many, one number or (joints,), at least 0; whole numbers keep the bits.

    Returns:
        In the shape and dtype of `angles`.
    """
    late = np.asarray(steps, np.float64)
    whole = np.floor(late)
    after = np.maximum(np.arange(angles.shape[-2])[:, None] - whole.astype(np.intp), 0)
    before = np.maximum(after - 1, 0)
    if late.ndim:
        column = np.arange(angles.shape[-1])
        here, there = angles[..., after, column], angles[..., before, column]
    else:  # whole rows are taken five times as fast
        here, there = angles[..., after[:, 0], :], angles[..., before[:, 0], :]
    return _between(here, there, late - whole)


def _between(
    here: NDArray[_Float], there: NDArray[_Float], share: NDArray[np.float64]
) -> NDArray[_Float]:
    """Interpolate in place of `there`, in the dtype of the angles."""
    there -= here
    there *= share.astype(there.dtype)
    there += here
    return there
