"""Roughness of joint motion, which wears out servos and gears; compiled code."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.portable.scalar import sin, tan

_f = np.float32
_ZERO, _ONE = _f(0.0), _f(1.0)
CUTOFF = 5.0  # Hz; no gait of a body of this size needs faster joint motion
# Quality factors of the two sections of a fourth-order Butterworth filter.
_QUALITIES = tuple(1 / (2 * sin(math.pi * k / 8)) for k in (1, 3))

# Working memory of one individual, by joint, so that loops over joints vectorise: the joint angles
# of some frames, one row per frame; the differences in the previous frame; the outputs of both
# sections in the last two frames; and sums of squares.
_FRAMES, _JOINTS = 64, 24
_OUTPUTS = ("y1", "y2", "z1", "z2")
_STATE = np.dtype(
    [
        ("angles", np.float32, (_FRAMES, _JOINTS)),
        *(
            (name, np.float32, (_JOINTS,))
            for name in ("angle", "first", "second", "third", *_OUTPUTS, "vibration", "jerk")
        ),
    ]
)


def high_pass(frame_rate: float) -> tuple[float, NDArray[np.float32]]:
    """Design a fourth-order Butterworth high-pass at 5 Hz with the bilinear transform.

    Both of its second-order sections take the second difference of their input.

    Returns:
        The gain, and the coefficients a1, a2 of each section in a row, (2, 2) float32.
    """
    warped = float(tan(math.pi * CUTOFF / frame_rate))
    square = warped * warped
    gain, poles = 1.0, []
    for quality in _QUALITIES:
        scale = 1 / (1 + warped / quality + square)
        gain *= scale
        poles.append((2 * (square - 1) * scale, (1 - warped / quality + square) * scale))
    return gain, np.array(poles, dtype=np.float32)


@njit(nogil=True, cache=True, error_model="numpy")
def roughness(
    angles: NDArray[np.float32],
    gain: float,
    poles: NDArray[np.float32],
    vibration: NDArray[np.float64],
    jerk: NDArray[np.float64],
) -> None:
    """Compute vibration and jerk of every individual.

    Args:
        angles: joint angles, (population, 24, frames) float32, radians.
        gain: gain from `high_pass`.
        poles: coefficients from `high_pass`, (2, 2) float32.
        vibration: output, (population,), radians: root mean square over frames and joints of the
            motion above 5 Hz, starting at rest in the first pose.
        jerk: output, (population,), radians per frame³: root mean square third difference.
    """
    population, joints, frames = angles.shape
    a1, a2, b1, b2 = poles[0, 0], poles[0, 1], poles[1, 0], poles[1, 1]
    states = np.empty(1, _STATE)
    for individual in range(population):
        # A record does not keep its array alive: Numba frees an array after its last use.
        state = states[0]
        angle, first, second, third = state.angle, state.first, state.second, state.third
        y1, y2, z1, z2 = state.y1, state.y2, state.z1, state.z2
        for joint in range(_JOINTS):
            angle[joint] = angles[individual, joint, 0]
            first[joint] = second[joint] = third[joint] = _ZERO
            y1[joint] = y2[joint] = z1[joint] = z2[joint] = _ZERO
            state.vibration[joint] = state.jerk[joint] = _ZERO
        for start in range(1, frames, _FRAMES):
            count = min(_FRAMES, frames - start)
            for joint in range(_JOINTS):
                for n in range(count):
                    state.angles[n, joint] = angles[individual, joint, start + n]
            for n in range(count):
                whole = _ONE if start + n >= 3 else _ZERO  # four frames are needed
                for joint in range(_JOINTS):
                    velocity = state.angles[n, joint] - angle[joint]
                    acceleration = velocity - first[joint]
                    change = acceleration - second[joint]
                    y = change - third[joint] - a1 * y1[joint] - a2 * y2[joint]
                    z = y - b1 * z1[joint] - b2 * z2[joint]
                    angle[joint] = state.angles[n, joint]
                    first[joint], second[joint], third[joint] = velocity, acceleration, change
                    y2[joint], y1[joint] = y1[joint], y
                    z2[joint], z1[joint] = z1[joint], z
                    state.vibration[joint] += z * z
                    state.jerk[joint] += whole * (change * change)
        smooth = rough = 0.0
        for joint in range(_JOINTS):
            smooth += state.vibration[joint]
            rough += state.jerk[joint]
        vibration[individual] = gain * math.sqrt(smooth / (frames * joints))
        jerk[individual] = math.sqrt(rough / ((frames - 3) * joints))
