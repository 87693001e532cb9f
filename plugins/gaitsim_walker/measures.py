"""Measures that describe a walk."""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from gaitsim.contracts import Array, Measure, Motion
from gaitsim.legged import BODY_HEIGHT, stepping_measures
from gaitsim_walker import body
from gaitsim_walker.body import Plan


def measures(motion: Motion, plan: Plan) -> Mapping[str, Measure]:
    """Return distance, duration, steadiness, effort, slip and steps.

    Means over time end at the fall.

    Args:
        motion: motion of a population.
        plan: build of the body.
    """
    forward = motion["torso"][:, -1, 0] - motion["torso"][:, 0, 0]
    lasted, energy = motion["lasted"], motion["energy"][:, -1]
    path = np.abs(np.diff(motion["torso"][..., 0], axis=1)).sum(axis=1)
    pitch = np.degrees(motion["pitch"])
    upright = np.round(lasted * motion.frame_rate).astype(np.intp) + 1
    return {
        "forward": Measure(forward, "m", "displacement of the torso"),
        "body lengths": Measure(
            forward / body.TORSO_LENGTH,
            "",
            f"forward displacement in torso lengths of {body.TORSO_LENGTH:g} m",
        ),
        "lasted": Measure(lasted, "s", "time until the fall, or the length of the rollout"),
        "cost of transport": Measure(
            _ratio(energy, motion["weight"] * np.abs(forward)),
            "",
            "work divided by weight times displacement",
        ),
        "pitch range": Measure(np.ptp(pitch, axis=1), "°", "range of the torso's pitch"),
        BODY_HEIGHT: Measure(
            partial(_height, motion["height"], upright),
            "m",
            "mean height of the torso's middle above the ground",
        ),
        "slip ratio": Measure(
            _ratio(motion["slip"].sum(axis=1), path),
            "",
            "slide of the stance feet divided by the torso's path",
        ),
        **stepping_measures(
            motion["stance"],
            [leg.name for leg in plan.legs],
            motion.frame_rate,
            sides=plan.sides,
            upright=upright,
        ),
    }


def _height(height: Array, upright: Array) -> Array:
    counted = np.arange(height.shape[1]) < upright[:, None]
    mean: Array = np.where(counted, height, 0.0).sum(axis=1) / upright
    return mean


def _ratio(part: Array, whole: Array) -> Array:
    """Return part / whole; infinite for a whole of 0."""
    ratio: Array = np.divide(part, whole, out=np.full(len(part), math.inf), where=whole > 0)
    return ratio
