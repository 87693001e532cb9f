"""Limits of joint angles, time steps, amplitudes and servo speeds."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def amplitude_limit(
    frequency: float, angle_limit: ArrayLike, speed_limit: ArrayLike
) -> NDArray[np.float64]:
    """Return the largest amplitude with which a sine stays within both limits of its joint.

    The largest speed of a sine of amplitude A is 2πAf.

    Args:
        frequency: frequency f of the sine, Hz.
        angle_limit: largest absolute angle, rad, for all joints or (joints,).
        speed_limit: largest angular speed, rad/s, for all joints or (joints,).

    Returns:
        The amplitude, rad, in the common shape of both limits.
    """
    speed = np.asarray(speed_limit, np.float64) / (2 * math.pi * frequency)
    return np.asarray(np.minimum(np.asarray(angle_limit, np.float64), speed))


def check_joint_angles(joint_angles: NDArray[Any], joints: int) -> None:
    """Check joint angles, (population, frames, joints) rad, that a body is to play.

    Raises:
        ValueError: the shape is different, there are fewer than 2 frames, or angles are not finite.
    """
    shape = joint_angles.shape
    if len(shape) != 3 or shape[1] < 2 or shape[2] != joints:
        raise ValueError(
            f"joint_angles has the shape {shape}, expected (population, frames, joints) with at "
            f"least 2 frames and {joints} joints"
        )
    if not np.isfinite(joint_angles).all():
        raise ValueError("some joint_angles are not finite")


def check_time_step(dt: float, frame_rate: float) -> None:
    """Check that a frame has a whole number of a simulation's time steps.

    Args:
        dt: time step, s.
        frame_rate: frames per second, Hz.

    Raises:
        ValueError: the number of time steps is not whole; the message suggests a similar time step.
    """
    steps = 1 / (frame_rate * dt)
    if not math.isclose(steps, round(steps), rel_tol=1e-3):
        near = 1 / (frame_rate * round(steps))
        raise ValueError(
            f"a frame of 1/{frame_rate:g} s is not a whole number of time steps of {dt:g} s; "
            f"{near:.4g} s divides it"
        )


def limit_steps(
    angles: NDArray[np.floating[Any]], step_limit: ArrayLike
) -> NDArray[np.floating[Any]]:
    """Return the angles of servos that follow `angles` but turn at most `step_limit` per frame.

    Angles within the limit are returned unchanged, bit for bit.

    Args:
        angles: commanded angles, (population, joints, frames) rad; not changed.
        step_limit: largest change from frame to frame, rad, for all joints or (joints,).

    Returns:
        The angles of the servos, (population, joints, frames) rad, in the dtype of `angles`.
    """
    limited = angles.copy()
    step = np.asarray(step_limit, angles.dtype)
    for frame in range(1, angles.shape[2]):
        before = limited[:, :, frame - 1]
        limited[:, :, frame] = np.clip(angles[:, :, frame], before - step, before + step)
    return limited
