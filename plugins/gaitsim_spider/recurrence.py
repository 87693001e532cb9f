"""The source's recurrence, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(nogil=True, cache=True, error_model="numpy")
def recur(
    genomes: NDArray[np.float32], step_limit: Any, angle_limit: Any, angles: NDArray[np.float32]
) -> None:
    """θ ← clip(θ + clip(w θ + b, ±step_limit), ±angle_limit), beginning with 0.

    Args:
        genomes: (population, 2 × joints) float32: weight and bias of each joint in turn.
        step_limit: radians a frame, float32.
        angle_limit: radians, float32.
        angles: filled, (population, joints, frames) float32, radians.
    """
    population, joints, frames = angles.shape
    numbers = np.empty((3, joints), dtype=np.float32)
    weight, bias, now = numbers[0], numbers[1], numbers[2]
    for individual in range(population):
        # Copied, as vector instructions load neighbours.
        weight[:], bias[:] = genomes[individual, ::2], genomes[individual, 1::2]
        now[:] = np.float32(0.0)
        for frame in range(frames):
            # Joints innermost: the map is serial in time, but not across joints.
            for joint in range(joints):
                angles[individual, joint, frame] = now[joint]
                step = weight[joint] * now[joint] + bias[joint]
                step = min(max(step, -step_limit), step_limit)
                now[joint] = min(max(now[joint] + step, -angle_limit), angle_limit)
