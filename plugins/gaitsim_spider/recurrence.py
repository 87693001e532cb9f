"""The recurrence of the original MATLAB project; compiled code."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


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
        weight[:], bias[:] = genomes[individual, ::2], genomes[individual, 1::2]
        now[:] = np.float32(0.0)
        for frame in range(frames):
            # Joints are the innermost loop: the map is serial in time, but not across joints.
            for joint in range(joints):
                angles[individual, joint, frame] = now[joint]
                step = weight[joint] * now[joint] + bias[joint]
                step = min(max(step, -step_limit), step_limit)
                now[joint] = min(max(now[joint] + step, -angle_limit), angle_limit)
