"""Quantities of single feet and joints, for `spider-classic`; compiled code."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

_f = np.float32
_ZERO: Any = _f(0.0)
_ONE: Any = _f(1.0)


@njit(nogil=True, cache=True, error_model="numpy")
def leg_by_leg(
    feet: NDArray[np.float32],
    angles: NDArray[np.float32],
    floor: Any,
    band: Any,
    frozen_below: Any,
    crossing: Any,
    sums: NDArray[np.float64],
) -> None:
    """Compute the seven quantities that `spider-classic` weights.

    Args:
        feet: feet in the body's frame, (population, 3, 8, frames) float32, metres.
        angles: joint angles, (population, 24, frames) float32, radians.
        floor: height of the floor in the body's frame, metres.
        band: half the height of the stance band around the floor, metres.
        frozen_below: travel along x below which a foot is frozen, metres.
        crossing: coxa angle at which legs cross, radians.
        sums: output, (population, 7): travel along x in metres, mean of the feet; share
            of feet and frames in the band; share of frozen feet; mean depth below the
            floor in metres; mean over frames of the variance of heights in the band in
            m²; mean coxa angle beyond crossing in radians; mean squared change of a
            joint from frame to frame in rad².
    """
    population, _, legs, frames = feet.shape
    joints = angles.shape[1]
    # Sums over legs or joints in each frame vectorise, unlike sums over frames.
    count, total, squares = np.empty(frames, _f), np.empty(frames, _f), np.empty(frames, _f)
    depth, excess, turned = np.empty(frames, _f), np.empty(frames, _f), np.empty(frames, _f)
    for individual in range(population):
        for frame in range(frames):
            count[frame] = total[frame] = squares[frame] = _ZERO
            depth[frame] = excess[frame] = turned[frame] = _ZERO
        travel = deep = over = change = uneven = in_band = frozen = 0.0
        for leg in range(legs):
            path = _ZERO
            for frame in range(1, frames):
                path += abs(feet[individual, 0, leg, frame] - feet[individual, 0, leg, frame - 1])
            travel += path
            frozen += path < frozen_below
            for frame in range(frames):
                height = feet[individual, 2, leg, frame] - floor
                depth[frame] += max(-height, _ZERO)
                supports = _ONE if abs(height) <= band else _ZERO
                count[frame] += supports
                total[frame] += supports * height
                squares[frame] += supports * height * height
            for frame in range(frames):
                excess[frame] += max(abs(angles[individual, 3 * leg, frame]) - crossing, _ZERO)
        for joint in range(joints):
            for frame in range(1, frames):
                step = angles[individual, joint, frame] - angles[individual, joint, frame - 1]
                turned[frame] += step * step
        for frame in range(frames):
            in_band += count[frame]
            mean = total[frame] / max(count[frame], _ONE)
            uneven += max(squares[frame] / max(count[frame], _ONE) - mean * mean, _ZERO)
            deep += depth[frame]
            over += excess[frame]
            change += turned[frame]
        sums[individual, 0] = travel / legs
        sums[individual, 1] = in_band / (legs * frames)
        sums[individual, 2] = frozen / legs
        sums[individual, 3] = deep / (legs * frames)
        sums[individual, 4] = uneven / frames
        sums[individual, 5] = over / (legs * frames)
        sums[individual, 6] = change / ((frames - 1) * joints)
