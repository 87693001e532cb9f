"""Roughness of joint motion, which wears servos and gears; compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_f = np.float32
CUTOFF = 5.0  # Hz; no gait of this size needs motion above it
# Quality factors of the two sections of a fourth-order Butterworth filter.
_QUALITIES = tuple(1 / (2 * math.sin(math.pi * k / 8)) for k in (1, 3))


def high_pass(frame_rate: float) -> NDArray[np.float32]:
    """Design a fourth-order Butterworth high-pass at 5 Hz by the bilinear transform.

    Returns:
        (2, 5) float32, a row of b0, b1, b2, a1, a2 for each second-order section.
    """
    warped = math.tan(math.pi * CUTOFF / frame_rate)
    sections = []
    for quality in _QUALITIES:
        scale = 1 / (1 + warped / quality + warped**2)
        a1 = 2 * (warped**2 - 1) * scale
        a2 = (1 - warped / quality + warped**2) * scale
        sections.append((scale, -2 * scale, scale, a1, a2))
    return np.array(sections, dtype=np.float32)


@njit(nogil=True, cache=True, error_model="numpy")
def roughness(
    angles: NDArray[np.float32],
    filters: NDArray[np.float32],
    vibration: NDArray[np.float64],
    jerk: NDArray[np.float64],
) -> None:
    """Compute vibration and jerk of every individual.

    Args:
        angles: (population, joints, frames) float32, radians.
        filters: (sections, 5) float32, from `high_pass`.
        vibration: filled, (population,), radians: root mean square over frames and
            joints of the motion above 5 Hz, from the first pose.
        jerk: filled, (population,), radians a frame³: root mean square third difference.
    """
    population, joints, frames = angles.shape
    state = np.empty((len(filters), 2, joints), dtype=_f)
    squares, cubes = np.empty(joints, dtype=_f), np.empty(joints, dtype=_f)
    signal = np.empty(joints, dtype=_f)
    for individual in range(population):
        state[:] = _f(0.0)
        squares[:] = _f(0.0)
        course = angles[individual]
        for frame in range(frames):
            for joint in range(joints):
                signal[joint] = course[joint, frame] - course[joint, 0]
            for section in range(len(filters)):
                b0, b1, b2, a1, a2 = filters[section]
                for joint in range(joints):  # direct form II, transposed
                    before = signal[joint]
                    after = b0 * before + state[section, 0, joint]
                    state[section, 0, joint] = b1 * before - a1 * after + state[section, 1, joint]
                    state[section, 1, joint] = b2 * before - a2 * after
                    signal[joint] = after
            for joint in range(joints):
                squares[joint] += signal[joint] * signal[joint]
        for joint in range(joints):
            total = _f(0.0)
            for frame in range(3, frames):
                third = (
                    course[joint, frame]
                    - _f(3.0) * (course[joint, frame - 1] - course[joint, frame - 2])
                    - course[joint, frame - 3]
                )
                total += third * third
            cubes[joint] = total
        smooth = rough = 0.0
        for joint in range(joints):
            smooth += squares[joint]
            rough += cubes[joint]
        vibration[individual] = math.sqrt(smooth / (frames * joints))
        jerk[individual] = math.sqrt(rough / ((frames - 3) * joints))
