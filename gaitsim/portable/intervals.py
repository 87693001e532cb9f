"""Intervals with the largest sum; compiled code."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(nogil=True, cache=True)
def mark_largest_intervals(worth: Floats, stride: Floats, chosen: NDArray[np.bool_]) -> None:
    """Mark the interval with the largest sum in each stride, unless no sum is positive.

    Source: J. Bentley, Programming pearls: algorithm design techniques, Communications of the ACM
    27 (1984) 865-873.

    Args:
        worth: worth of each frame, (population, frames).
        stride: number of the stride of each frame, ascending, (population, frames).
        chosen: output, False everywhere, (population, frames).
    """
    for n in range(len(worth)):
        best = total = 0.0
        begin = start = end = 0
        for frame in range(worth.shape[1]):
            if frame and stride[n, frame] != stride[n, frame - 1]:
                chosen[n, start:end] = True
                best = total = 0.0
                begin = start = end = frame
            if total < 0.0:
                total, begin = 0.0, frame
            total += worth[n, frame]
            if total > best:
                best, start, end = total, begin, frame + 1
        chosen[n, start:end] = True
