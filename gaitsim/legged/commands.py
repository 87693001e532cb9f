"""Timing of servo commands: hold each command until the next one is sent, and delay it."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_Float = TypeVar("_Float", bound=np.floating[Any])


def hold_commands(
    commands: NDArray[_Float], frame_rate: float, rate: float, steps: int = 1
) -> NDArray[_Float]:
    """Return the commands in force in each step, for a controller with a fixed command rate.

    Each command is the gait's pose at the moment of sending, interpolated between frames.

    Args:
        commands: commanded angles, (…, frames, joints) rad.
        frame_rate: frame rate of `commands`, Hz.
        rate: command rate of the controller, Hz. If it equals the frame rate, the angles of each
            frame are copied bit for bit.
        steps: number of steps per frame.

    Returns:
        The commands, (…, frames · steps, joints) rad, in the dtype of `commands`.
    """
    return commands_at(commands, np.arange(commands.shape[-2] * steps) / steps, frame_rate / rate)


def commands_at(
    commands: NDArray[_Float], moments: NDArray[np.float64], period: float
) -> NDArray[_Float]:
    """Return the commands in force at given moments, for a controller as in `hold_commands`.

    Args:
        commands: commanded angles, (…, frames, joints) rad.
        moments: times, (moments,) frames.
        period: time between commands, frames.

    Returns:
        The commands, (…, moments, joints) rad.
    """
    # Without the 1e-9, rounding errors would delay some commands by a step.
    sent = np.floor(moments / period + 1e-9) * period
    before = sent.astype(np.intp)
    after = np.minimum(before + 1, commands.shape[-2] - 1)
    share = (sent - before)[:, None]
    return _interpolate(commands[..., before, :], commands[..., after, :], share)


def delay_angles(angles: NDArray[_Float], steps: NDArray[Any] | float) -> NDArray[_Float]:
    """Delay joint angles, interpolating between steps; joints first hold their initial angle.

    Args:
        angles: joint angles, (…, steps, joints) rad.
        steps: delay in steps, at least 0: one number for all joints, or (joints,). A delay of whole
            steps copies the angles bit for bit.

    Returns:
        The delayed angles, in the shape and dtype of `angles`.
    """
    late = np.asarray(steps, np.float64)
    whole = np.floor(late)
    after = np.maximum(np.arange(angles.shape[-2])[:, None] - whole.astype(np.intp), 0)
    before = np.maximum(after - 1, 0)
    if late.ndim:
        column = np.arange(angles.shape[-1])
        here, there = angles[..., after, column], angles[..., before, column]
    else:  # indexing whole rows is five times faster
        here, there = angles[..., after[:, 0], :], angles[..., before[:, 0], :]
    return _interpolate(here, there, late - whole)


def _interpolate(
    here: NDArray[_Float], there: NDArray[_Float], share: NDArray[np.float64]
) -> NDArray[_Float]:
    """Interpolate from `here` to `there`; overwrite `there` and keep its dtype."""
    there -= here
    there *= share.astype(there.dtype)
    there += here
    return there
