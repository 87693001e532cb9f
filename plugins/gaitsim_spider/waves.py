"""Joint angles of the recurrence of the MATLAB project, and of sine waves; compiled code."""

from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import compiled_sin_and_cos as sin_and_cos, cos, sin


@njit(nogil=True, cache=True, error_model="numpy")
def recur(
    genomes: NDArray[np.float32], step_limit: Any, angle_limit: Any, angles: NDArray[np.float32]
) -> None:
    """Iterate θ ← clip(θ + clip(w θ + b, ±step_limit), ±angle_limit) from 0.

    Args:
        genomes: weight and bias of each joint in turn, (population, 2 × joints) float32.
        step_limit: largest change of an angle, radians per frame, float32.
        angle_limit: largest angle, radians, float32.
        angles: output, (population, joints, frames) float32, radians.
    """
    population, joints, frames = angles.shape
    numbers = np.empty((3, joints), dtype=np.float32)
    weight, bias, now = numbers[0], numbers[1], numbers[2]
    for individual in range(population):
        # Contiguous copies, so that the loop over joints vectorises.
        for joint in range(joints):  # an assignment of slices would take 3 s more to compile
            weight[joint] = genomes[individual, 2 * joint]
            bias[joint] = genomes[individual, 2 * joint + 1]
            now[joint] = np.float32(0.0)
        for frame in range(frames):
            # Joints are the innermost loop: the map is serial in time, but not across joints.
            for joint in range(joints):
                angles[individual, joint, frame] = now[joint]
                step = weight[joint] * now[joint] + bias[joint]
                step = min(max(step, -step_limit), step_limit)
                now[joint] = min(max(now[joint] + step, -angle_limit), angle_limit)


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
