"""Sine waves of one frequency; compiled code."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(nogil=True, cache=True, error_model="numpy")
def sum_waves(
    sine: NDArray[np.float32],
    cosine: NDArray[np.float32],
    sine_weight: NDArray[np.float32],
    cosine_weight: NDArray[np.float32],
    angles: NDArray[np.float32],
) -> None:
    """Compute a weighted sum of a sine and a cosine for each joint.

    Args:
        sine: sine in each frame, (frames,) float32.
        cosine: cosine in each frame, (frames,) float32.
        sine_weight: weight of the sine, (population, joints) float32, radians.
        cosine_weight: weight of the cosine, (population, joints) float32, radians.
        angles: output, (population, joints, frames) float32, radians.
    """
    for individual in range(angles.shape[0]):
        for joint in range(angles.shape[1]):
            a, b = sine_weight[individual, joint], cosine_weight[individual, joint]
            for frame in range(angles.shape[2]):
                angles[individual, joint, frame] = a * sine[frame] + b * cosine[frame]
