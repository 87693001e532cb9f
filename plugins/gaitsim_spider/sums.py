"""Sums over the frames of a gait, for `spider-walk` and `spider-classic`; compiled code."""

import math
from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import compiled, scalar_sin as sin, scalar_tan as tan

_f = np.float32
_ZERO: Any = _f(0.0)
_ONE: Any = _f(1.0)
CUTOFF = 5.0  # Hz; no gait of a body of this size needs faster joint motion
# Quality factors of the two sections of a fourth-order Butterworth filter.
_QUALITIES = tuple(1 / (2 * sin(math.pi * k / 8)) for k in (1, 3))

# Working memory of one individual, by joint, so that loops over joints vectorise: the joint angles
# of four frames, one row per frame; the differences in the previous frame; the outputs of both
# sections in the last two frames; and sums of squares. Four frames at once take a fifth less time,
# as reading and writing these numbers takes longer than the arithmetic.
_FRAMES, _JOINTS = 4, 24
_OUTPUTS = ("y1", "y2", "z1", "z2")
STATE = np.dtype(
    [
        ("angles", np.float32, (_FRAMES, _JOINTS)),
        *(
            (name, np.float32, (_JOINTS,))
            for name in ("angle", "first", "second", "third", *_OUTPUTS, "vibration", "jerk")
        ),
    ]
)


@cache
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


@compiled.inner
def _roughness(angles: Any, gain: float, poles: Any, state: Any) -> tuple[float, float]:
    """Return vibration and jerk of one individual, whose angles are (24, frames) float32."""
    joints, frames = angles.shape
    a1, a2, b1, b2 = poles[0, 0], poles[0, 1], poles[1, 0], poles[1, 1]
    angle, first, second, third = state.angle, state.first, state.second, state.third
    y1, y2, z1, z2 = state.y1, state.y2, state.z1, state.z2
    some, squares, jerks = state.angles, state.vibration, state.jerk
    for joint in range(_JOINTS):
        angle[joint] = angles[joint, 0]
        first[joint] = second[joint] = third[joint] = _ZERO
        y1[joint] = y2[joint] = z1[joint] = z2[joint] = _ZERO
        squares[joint] = jerks[joint] = _ZERO
    # The body rests before the first frame, which adds nothing to the sums.
    for start in range(-(-frames % _FRAMES), frames, _FRAMES):
        for n in range(_FRAMES):
            frame = start + n if start + n > 0 else 0
            for joint in range(_JOINTS):
                some[n, joint] = angles[joint, frame]
        for joint in range(_JOINTS):
            a, b, c, d = angle[joint], first[joint], second[joint], third[joint]
            y, before, z, earlier = y1[joint], y2[joint], z1[joint], z2[joint]
            square, jerk = squares[joint], jerks[joint]
            for n in range(_FRAMES):
                whole = _ONE if start + n >= 3 else _ZERO  # four frames are needed
                velocity = some[n, joint] - a
                acceleration = velocity - b
                change = acceleration - c
                y, before = change - d - a1 * y - a2 * before, y
                z, earlier = y - b1 * z - b2 * earlier, z
                a, b, c, d = some[n, joint], velocity, acceleration, change
                square += z * z
                jerk += whole * (change * change)
            angle[joint], first[joint], second[joint], third[joint] = a, b, c, d
            y1[joint], y2[joint], z1[joint], z2[joint] = y, before, z, earlier
            squares[joint], jerks[joint] = square, jerk
    smooth = rough = 0.0
    for joint in range(_JOINTS):
        smooth += squares[joint]
        rough += jerks[joint]
    smooth, rough = smooth / (frames * joints), rough / ((frames - 3) * joints)
    return gain * math.sqrt(smooth), math.sqrt(rough)


@njit(nogil=True, cache=True, error_model="numpy")
def sum_frames(
    pose: NDArray[np.float32],
    slip: NDArray[np.float32],
    margin: NDArray[np.float32],
    slope: NDArray[np.float32],
    angles: NDArray[np.float32],
    safe_margin: np.float32,
    gain: float,
    poles: NDArray[np.float32],
    states: NDArray[np.void],
    sums: NDArray[np.float64],
) -> None:
    """Compute the eight quantities that `spider-walk` weights, in double precision.

    Args:
        pose: x, y and yaw of the body, (population, 3, frames), metres and radians.
        slip: slide of the stance feet until the next frame, (population, frames), metres.
        margin: static stability margin, (population, frames), metres.
        slope: tilt of the resting plane, (population, frames), radians.
        angles: joint angles, (population, 24, frames), radians.
        safe_margin: margin below which a frame counts as unsupported, metres.
        gain: gain from `high_pass`.
        poles: coefficients from `high_pass`, (2, 2) float32.
        states: working memory, (1,) of dtype `STATE`.
        sums: output, (population, 8): distance ahead in metres; slide in metres; mean distance
            from the straight line ahead in metres; RMS yaw and RMS slope in radians; share of
            unsupported frames; vibration in radians, the RMS over frames and joints of the motion
            above 5 Hz, starting at rest in the first pose; and jerk in radians per frame³, the RMS
            third difference.
    """
    population, _, frames = pose.shape
    for individual in range(population):
        slid = aside = turned = tilted = 0.0
        unsupported = 0
        for frame in range(frames):
            # The last frame repeats the slip of the one before.
            slid += slip[individual, frame] if frame < frames - 1 else 0.0
            aside += abs(pose[individual, 1, frame])
            yaw, tilt = float(pose[individual, 2, frame]), float(slope[individual, frame])
            turned += yaw * yaw
            tilted += tilt * tilt
            unsupported += margin[individual, frame] < safe_margin
        sums[individual, 0] = pose[individual, 0, frames - 1]
        sums[individual, 1] = slid
        sums[individual, 2] = aside / frames
        sums[individual, 3] = math.sqrt(turned / frames)
        sums[individual, 4] = math.sqrt(tilted / frames)
        sums[individual, 5] = unsupported / frames
        vibration, jerk = _roughness(angles[individual], gain, poles, states[0])
        sums[individual, 6], sums[individual, 7] = vibration, jerk


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
        x = feet[individual, 0]
        for leg in range(0, legs, 4):
            # Four sums at a time, as each addition waits for the one before.
            a = b = c = d = _ZERO
            for frame in range(1, frames):
                a += abs(x[leg, frame] - x[leg, frame - 1])
                b += abs(x[leg + 1, frame] - x[leg + 1, frame - 1])
                c += abs(x[leg + 2, frame] - x[leg + 2, frame - 1])
                d += abs(x[leg + 3, frame] - x[leg + 3, frame - 1])
            for path in (a, b, c, d):
                travel += path
                frozen += path < frozen_below
        for leg in range(legs):
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
