"""Advance the rhythms of a population by one control step: inputs to joint angles.

The inverse kinematics is that of `Chain.solve`, with two iterations from the angles of the step
before. An exported controller computes the same.
"""

import copy
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin import SAMPLES, Inputs, Rhythm
from gaitsim.plugin.toolkit import compiled_sin_and_cos as sin_and_cos

Floats = NDArray[np.float64]

RAMP_TIME = 0.5  # s, duration of the transitions between standing and the full gait
RESTORING = 4.0  # 1/s, how quickly a leg's phase returns to that of the gait
ITERATIONS = 2  # of the inverse kinematics in each step
FARTHEST_TURN = 0.5  # rad, largest change of an angle in one iteration


class RhythmState:
    """The state of the rhythms of a population, standing at the start.

    Attributes:
        clock: phase of the gait, (population,) cycles.
        lead: deviation of each leg's phase, (population, legs) cycles.
        activity: 0 when standing to 1 in the full gait, (population,).
        angles: joint angles, (population, joints) rad.
        scale: factor of strokes that were too long, (population,); 1 for others.
    """

    def __init__(self, rhythm: Rhythm) -> None:
        population = len(rhythm)
        self.clock = np.zeros(population)
        self.lead = np.zeros((population, len(rhythm.names)))
        self.activity = np.zeros(population)
        joints = rhythm.standing.shape[-1]
        self.angles = np.broadcast_to(rhythm.standing, (population, joints)).copy()
        self.scale = np.ones(population)

    def select(self, individuals: NDArray[Any]) -> "RhythmState":
        """Return the state of some individuals."""
        found = copy.copy(self)
        for name, value in vars(self).items():
            setattr(found, name, value[individuals])
        return found

    def phase(self, rhythm: Rhythm) -> Floats:
        """Return the phase of each leg, (population, legs) cycles from 0 to 1."""
        found = self.clock[:, None] + self.lead + rhythm.offset
        return np.asarray(found - np.floor(found))


def advance(
    rhythm: Rhythm,
    state: RhythmState,
    walking: NDArray[np.bool_],
    inputs: Inputs,
    interval: float,
) -> Floats:
    """Advance the rhythms by one control step.

    Args:
        rhythm: rhythms of the population.
        state: their state, changed in place.
        walking: whether each individual should walk, (population,), or stand.
        inputs: commands with the changes of reflexes.
        interval: duration of the step, s.

    Returns:
        The joint angles, (population, joints) rad; a view of the state.
    """
    r, i = rhythm, inputs
    joints, legs = r.standing.shape[-1], len(r.names)
    # One body for all, or one for each individual.
    anchors, axes = r.anchors.reshape(-1, joints, 3), r.axes.reshape(-1, joints, 3)
    tips, weights = r.tips.reshape(-1, legs, 3), r.weights.reshape(-1, legs, 6)
    standing, lower, upper = (one.reshape(-1, joints) for one in (r.standing, r.lower, r.upper))
    _advance(
        r.first, anchors, axes, tips, standing, lower, upper, r.speed_limit, weights,
        np.reshape(r.length, -1), r.frequency, r.duty, r.offset, r.centre, r.stroke, r.path,
        r.longest, r.gains, r.own_speed, walking, i.command, i.stride, i.reach, i.rate, interval,
        state.clock, state.lead, state.activity, state.angles, state.scale,
    )  # fmt: skip
    return state.angles


@njit(nogil=True, cache=True, error_model="numpy")
def _advance(
    first: Any, anchors: Any, axes: Any, tips: Any, standing: Any, lower: Any, upper: Any,
    speed_limit: Any, weights: Any, length: Any, frequency: Any, duty: Any, offset: Any,
    centre: Any, stroke: Any, path: Any, longest: Any, gains: Any, own_speed: Any, walking: Any,
    command: Any, stride: Any, reach: Any, rate: Any, interval: Any,
    clock: Any, lead: Any, activity: Any, angles: Any, scale: Any,
) -> None:  # fmt: skip
    """Advance the rhythms; for the arguments, see `advance`, `Rhythm`, `Inputs`, `RhythmState`."""
    legs = len(first) - 1
    strokes = np.empty((legs, 2))
    target = np.empty(3)
    most = 0
    for leg in range(legs):
        most = max(most, first[leg + 1] - first[leg])
    room = (
        np.empty(3), np.empty((3, 3)), np.empty((most, 3)), np.empty((most, 3)), np.empty(6),
        np.empty((most, 6)), np.empty((most, most)), np.empty(most), np.empty(most),
    )  # fmt: skip
    small = interval / RAMP_TIME
    for n in range(len(frequency)):
        own = n if len(tips) > 1 else 0
        middle_x, middle_y = tips[own, :, 0].mean(), tips[own, :, 1].mean()
        change = (1.0 if walking[n] else 0.0) - activity[n]
        active = activity[n] + min(max(change, -small), small)
        activity[n] = active
        if active == 0.0:
            clock[n] = 0.0
            lead[n] = 0.0
        cycle = frequency[n] * interval
        if active > 0.0:
            clock[n] = (clock[n] + cycle) % 1.0
            for leg in range(legs):
                drift = cycle * (rate[n, leg] - 1.0) - RESTORING * interval * lead[n, leg]
                lead[n, leg] += min(max(drift, -cycle), 0.25)
        # Strokes that the command asks for; feet move against the trunk's motion.
        duration = duty[n] / frequency[n]
        forward = command[n, 0] / max(own_speed[n], 1e-9)
        turn = command[n, 1] / gains[n, 1] * duration
        aside = command[n, 2] / gains[n, 2] * duration
        farthest = 0.0
        for leg in range(legs):
            stretched = forward * stride[n, leg]
            strokes[leg, 0] = stretched * stroke[n, leg, 0] - turn * (tips[own, leg, 1] - middle_y)
            strokes[leg, 1] = (
                stretched * stroke[n, leg, 1] + turn * (tips[own, leg, 0] - middle_x) + aside
            )
            far = np.sqrt(strokes[leg, 0] * strokes[leg, 0] + strokes[leg, 1] * strokes[leg, 1])
            farthest = max(farthest, far)
        scale[n] = longest[n] / farthest if farthest > longest[n] else 1.0
        for leg in range(legs):
            phase = clock[n] + lead[n, leg] + offset[n, leg]
            place = (phase - np.floor(phase)) * SAMPLES
            sample = min(int(place), SAMPLES - 1)
            t = place - sample
            for k in range(3):  # periodic cubics, as in `encodings.interpolate_cycle`
                a = path[n, leg, (sample - 1) % SAMPLES, k]
                b = path[n, leg, sample, k]
                c = path[n, leg, (sample + 1) % SAMPLES, k]
                d = path[n, leg, (sample + 2) % SAMPLES, k]
                target[k] = b + 0.5 * t * (
                    c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))
                )
            ahead = target[0] * scale[n]
            target[0] = active * (centre[n, leg, 0] + ahead * strokes[leg, 0])
            target[1] = active * (centre[n, leg, 1] + target[1] + ahead * strokes[leg, 1])
            target[2] = active * (centre[n, leg, 2] + target[2]) - command[n, 3] - reach[n, leg]
            for k in range(3):
                target[k] += tips[own, leg, k]
            _follow(
                first[leg], first[leg + 1], anchors[own], axes[own], tips[own, leg], standing[own],
                lower[own], upper[own], weights[own, leg], length[own], speed_limit, interval,
                target, angles[n], room,
            )  # fmt: skip


@njit(nogil=True, cache=True, error_model="numpy")
def _follow(
    low: Any, high: Any, anchors: Any, axes: Any, tip: Any, standing: Any, lower: Any, upper: Any,
    weights: Any, length: Any, speed_limit: Any, interval: Any, target: Any, angles: Any, room: Any,
) -> None:  # fmt: skip
    """Move a leg's angles so that its foot follows its target, within limits of angle and speed.

    The leg has the joints from `low` to `high`. `target` is the place of its foot, (3,) m; `angles`
    are those of all joints, (joints,) rad, of which the leg's are changed in place; `room` has
    arrays for intermediate results; the other arguments are those of `Rhythm`.
    """
    foot, rotation, anchor, axis, error, slope, normal, step, before = room
    joints = high - low
    for j in range(joints):  # an assignment of slices would take 3 s more to compile
        before[j] = angles[low + j]
    for _ in range(ITERATIONS):
        _place(low, joints, anchors, axes, tip, standing, angles, foot, rotation, anchor, axis)
        # Errors of the position, and of the rotation to first order.
        for k in range(3):
            error[k] = weights[k] * (target[k] - foot[k])
        error[3] = weights[3] * 0.5 * (rotation[1, 2] - rotation[2, 1])
        error[4] = weights[4] * 0.5 * (rotation[2, 0] - rotation[0, 2])
        error[5] = weights[5] * 0.5 * (rotation[0, 1] - rotation[1, 0])
        damping = 1e-6 * length * length
        for k in range(6):
            damping += 0.5 * error[k] * error[k]
        for j in range(joints):
            x, y, z = foot[0] - anchor[j, 0], foot[1] - anchor[j, 1], foot[2] - anchor[j, 2]
            slope[j, 0] = weights[0] * (axis[j, 1] * z - axis[j, 2] * y)
            slope[j, 1] = weights[1] * (axis[j, 2] * x - axis[j, 0] * z)
            slope[j, 2] = weights[2] * (axis[j, 0] * y - axis[j, 1] * x)
            for k in range(3):
                slope[j, 3 + k] = weights[3 + k] * axis[j, k]
            downhill = 0.0
            for k in range(6):
                downhill += slope[j, k] * error[k]
            angle = angles[low + j]
            if (angle <= lower[low + j] and downhill < 0.0) or (
                angle >= upper[low + j] and downhill > 0.0
            ):
                downhill = 0.0
                slope[j, :] = 0.0
            step[j] = downhill
        _solve(joints, slope, damping, normal, step)
        for j in range(joints):
            angle = angles[low + j] + min(max(step[j], -FARTHEST_TURN), FARTHEST_TURN)
            angles[low + j] = min(max(angle, lower[low + j]), upper[low + j])
    for j in range(joints):
        most = speed_limit[low + j] * interval
        angles[low + j] = min(max(angles[low + j], before[j] - most), before[j] + most)


@njit(nogil=True, cache=True, error_model="numpy")
def _place(
    low: Any, joints: Any, anchors: Any, axes: Any, tip: Any, standing: Any, angles: Any,
    foot: Any, rotation: Any, anchor: Any, axis: Any,
) -> None:  # fmt: skip
    """Compute the place of a leg's foot, its rotation, and the place and direction of the axes."""
    for i in range(3):
        foot[i] = 0.0
        for k in range(3):
            rotation[i, k] = 1.0 if i == k else 0.0
    for j in range(joints):
        sine, cosine = sin_and_cos(angles[low + j] - standing[low + j])
        x, y, z = axes[low + j, 0], axes[low + j, 1], axes[low + j, 2]
        for i in range(3):
            a, b, c = rotation[i, 0], rotation[i, 1], rotation[i, 2]
            along = a * x + b * y + c * z
            anchor[j, i] = foot[i] + (
                a * anchors[low + j, 0] + b * anchors[low + j, 1] + c * anchors[low + j, 2]
            )
            axis[j, i] = along
            along *= 1.0 - cosine
            # Rodrigues' formula for a row, which turns backward.
            rotation[i, 0] = a * cosine - (y * c - z * b) * sine + x * along
            rotation[i, 1] = b * cosine - (z * a - x * c) * sine + y * along
            rotation[i, 2] = c * cosine - (x * b - y * a) * sine + z * along
            foot[i] = anchor[j, i] - (
                rotation[i, 0] * anchors[low + j, 0]
                + rotation[i, 1] * anchors[low + j, 1]
                + rotation[i, 2] * anchors[low + j, 2]
            )
    for i in range(3):
        foot[i] += rotation[i, 0] * tip[0] + rotation[i, 1] * tip[1] + rotation[i, 2] * tip[2]


@njit(nogil=True, cache=True, error_model="numpy")
def _solve(joints: Any, slope: Any, damping: Any, normal: Any, step: Any) -> None:
    """Solve (S Sᵀ + damping) x = step in place by Cholesky's method; S is `slope`."""
    for i in range(joints):
        for j in range(i + 1):
            total = damping if i == j else 0.0
            for k in range(6):
                total += slope[i, k] * slope[j, k]
            for k in range(j):
                total -= normal[i, k] * normal[j, k]
            normal[i, j] = np.sqrt(total) if i == j else total / normal[j, j]
    for i in range(joints):
        total = step[i]
        for k in range(i):
            total -= normal[i, k] * step[k]
        step[i] = total / normal[i, i]
    for i in range(joints - 1, -1, -1):
        total = step[i]
        for k in range(i + 1, joints):
            total -= normal[k, i] * step[k]
        step[i] = total / normal[i, i]
