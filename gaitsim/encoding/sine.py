"""The sine encoding: every joint swings by a sine of one frequency."""

import math

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from gaitsim.encoding.waves import Floats, checked, phases, waves


def sine(
    amplitude: Floats,
    phase: Floats,
    lag: Floats,
    frequency: ArrayLike,
    *,
    oscillators: NDArray[np.intp],
    frames: int,
    frame_rate: float,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """Return the joint angles θ(t) = A sin(2πft + φ + λ).

    Args:
        amplitude: A, (population, joints) rad.
        phase: φ of each oscillator, (population, oscillators) rad.
        lag: λ of each joint behind its oscillator, (population, joints) rad.
        frequency: f, Hz, one for all individuals or (population,).
        oscillators: index of the oscillator of each joint, (joints,).
        frames: number of frames; the first is at t = 0.
        frame_rate: frames per second, Hz.
        dtype: float32 halves the time where all individuals share a frequency.

    Returns:
        (population, joints, frames) rad in `dtype`.

    Raises:
        ValueError: shapes that do not fit each other.
    """
    checked(amplitude, phase, lag, frequency, oscillators)
    if np.ndim(frequency):
        cycles = phases(phase, frequency, frames, frame_rate)
        return waves(amplitude, cycles.take(oscillators, axis=1), lag).astype(dtype, copy=False)
    joint_phase = phase.take(oscillators, axis=1) + lag
    cycle = 2 * math.pi * np.asarray(frequency, np.float64) / frame_rate * np.arange(frames)
    # By the addition theorem: two products an angle and hardly a sine.
    angles: Floats = _column(amplitude * np.cos(joint_phase), dtype) * np.sin(cycle).astype(dtype)
    angles += _column(amplitude * np.sin(joint_phase), dtype) * np.cos(cycle).astype(dtype)
    return angles


def _column(values: Floats, dtype: DTypeLike) -> Floats:
    return values.astype(dtype)[:, :, None]
