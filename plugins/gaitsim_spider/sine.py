"""Sine waves of one frequency; compiled code."""

from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.portable import cos, sin
from gaitsim.portable.compiled import sin_and_cos


@cache
def unit_waves(step: float, frames: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the sine and the cosine of `step` times the frame, (frames,) float32 each."""
    angles = [step * frame for frame in range(frames)]
    # Single numbers, for which nothing is compiled.
    sine = np.array([sin(angle) for angle in angles], np.float32)
    return sine, np.array([cos(angle) for angle in angles], np.float32)


@njit(nogil=True, cache=True, error_model="numpy")
def sum_waves(
    sine: NDArray[np.float32],
    cosine: NDArray[np.float32],
    amplitude: NDArray[np.float64],
    phase: NDArray[np.float64],
    lag: NDArray[np.float64],
    angles: NDArray[np.float32],
) -> None:
    """Compute θ = A sin(2πft + φ + λ) of each joint by the addition theorem.

    Args:
        sine: sin 2πft in each frame, (frames,) float32.
        cosine: cos 2πft in each frame, (frames,) float32.
        amplitude: amplitude A, (population, joints) float64, radians.
        phase: phase φ of each leg, (population, legs) float64, radians.
        lag: lag λ, (population, joints) float64, radians.
        angles: output, (population, joints, frames) float32, radians.
    """
    population, joints, frames = angles.shape
    of_leg = joints // phase.shape[1]
    for individual in range(population):
        for joint in range(joints):
            start = phase[individual, joint // of_leg] + lag[individual, joint]
            sine_of_start, cosine_of_start = sin_and_cos(start)
            a = np.float32(amplitude[individual, joint] * cosine_of_start)
            b = np.float32(amplitude[individual, joint] * sine_of_start)
            for frame in range(frames):
                angles[individual, joint, frame] = a * sine[frame] + b * cosine[frame]
