"""Measures that describe a robot's walk."""

import math
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np

from gaitsim.plugin import Array, Measure, Motion
from gaitsim.plugin.toolkit import (
    BODY_HEIGHT,
    STRIDE_FREQUENCY,
    arccos,
    cos,
    norm,
    stepping_measures,
)
from gaitsim_robot.anatomy import Floats, Leg, Side


def total(values: Array) -> Floats:
    """Return the sum of values, (population, …), over all axes but the population, (population,).

    NumPy sums each row of a contiguous array separately.
    """
    rows = np.ascontiguousarray(values, np.float64).reshape(len(values), -1)
    summed: Floats = np.add.reduce(rows, axis=1)
    return summed


def mean(values: Array) -> Floats:
    """Return the mean over all axes but the population, (population,)."""
    return total(values) / math.prod(values.shape[1:])


def rms(values: Array) -> Floats:
    """Return the root mean square over all axes but the population, (population,)."""
    return np.sqrt(mean(np.square(values)))


def ratio(part: Array, whole: Array, otherwise: float = 0.0) -> Floats:
    """Return part / whole in the shape of `part`, and `otherwise` where the whole is 0 or less."""
    found: Floats = np.divide(part, whole, out=np.full(part.shape, otherwise), where=whole > 0)
    return found


def measures(motion: Motion, legs: Sequence[Leg]) -> Mapping[str, Measure]:
    """Return displacement, speed, duration, effort, slip, steps and posture.

    Means over time end at the fall.
    """
    frames = np.arange(motion["height"].shape[1])
    upright = frames <= np.round(motion["lasted"] * motion.frame_rate)[:, None]
    roll, pitch, yaw = np.moveaxis(motion["orientation"], -1, 0)
    tilt = arccos(np.clip(cos(roll) * cos(pitch), -1.0, 1.0))
    return {
        **travel_measures(motion),
        **stepping_measures(
            motion["stance"],
            [leg.name for leg in legs],
            motion.frame_rate,
            sides=[[leg.name for leg in legs if leg.side == side] for side in get_args(Side)],
            upright=upright.sum(axis=1),
            commanded=motion[STRIDE_FREQUENCY],
        ),
        BODY_HEIGHT: Measure(
            _mean(motion["height"], upright), "m", "mean height of the trunk's origin above ground"
        ),
        "tilt": Measure(
            np.degrees(np.where(upright, tilt, 0.0).max(axis=1)),
            "°",
            "largest angle between the trunk and upright",
        ),
        "yaw": Measure(np.degrees(yaw[:, -1] - yaw[:, 0]), "°", "turn to the left at the end"),
    }


def travel_measures(motion: Motion) -> dict[str, Measure]:
    """Return displacement, speed, duration, effort and slip of any body on the ground."""
    moved = motion["torso"][:, -1] - motion["torso"][:, 0]
    displacement = norm(moved[:, :2])
    steps = np.diff(motion["torso"][..., :2], axis=1)
    path = total(norm(steps))
    lasted, energy = motion["lasted"], motion["energy"][:, -1]
    torque = motion["torque"].max(axis=1)
    return {
        "forward": Measure(moved[:, 0], "m", "displacement of the trunk along x"),
        "lateral": Measure(moved[:, 1], "m", "displacement of the trunk to the left"),
        "body lengths": Measure(
            displacement / motion["length"],
            "",
            f"displacement in body lengths of {float(motion['length'][0]):.3g} m",
        ),
        "speed": Measure(
            ratio(displacement, lasted), "m/s", "displacement divided by the time until the fall"
        ),
        "lasted": Measure(lasted, "s", "time until the fall, or the length of the rollout"),
        "cost of transport": Measure(
            ratio(energy, motion["weight"] * displacement, math.inf),
            "",
            "work divided by weight times displacement",
        ),
        "mean power": Measure(
            ratio(energy, lasted), "W", "work of the servos divided by the time until the fall"
        ),
        "peak torque": Measure(
            ratio(torque, motion["stall_torque"]).max(axis=1),
            "",
            "largest mean torque of a frame (20 ms) as a share of the stall torque: 1 is at stall; "
            "0 if unknown",
        ),
        "RMS torque": Measure(
            ratio(motion["rms_torque"], motion["stall_torque"]).max(axis=1),
            "",
            "root mean square torque of the most loaded joint as a share of its stall torque; 0 if "
            "unknown",
        ),
        "heat": Measure(
            ratio(motion["rms_torque"], motion["continuous_torque"]).max(axis=1),
            "",
            "root mean square torque of the hottest servo as a share of its continuous torque: "
            "above 1, it overheats; 0 if unknown",
        ),
        "slip ratio": Measure(
            ratio(total(motion["slip"]), path, math.inf),
            "",
            "slide of the stance feet divided by the trunk's path",
        ),
    }


def _mean(values: Array, chosen: Array) -> Floats:
    """Return the mean of values, (population, frames), over chosen frames, (population,)."""
    return total(np.where(chosen, values, 0.0)) / total(chosen)
