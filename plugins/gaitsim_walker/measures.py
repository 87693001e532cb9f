"""Measures of how a walker walked, for people."""

import math
from collections.abc import Mapping

import numpy as np

from gaitsim.contracts import Array, Measure, Motion
from gaitsim_walker import body


def measures(motion: Motion) -> Mapping[str, Measure]:
    """Return distance, duration, steadiness, effort, slip and stance."""
    forward = motion["torso"][:, -1, 0] - motion["torso"][:, 0, 0]
    lasted, energy = motion["lasted"], motion["energy"][:, -1]
    path = np.abs(np.diff(motion["torso"][..., 0], axis=1)).sum(axis=1)
    pitch = np.degrees(motion["pitch"])
    return {
        "forward": Measure(forward, "m", "displacement of the torso"),
        "body lengths": Measure(
            forward / body.TORSO_LENGTH,
            "",
            f"forward in torsos of {body.TORSO_LENGTH:g} m",
        ),
        "lasted": Measure(lasted, "s", "before the fall, or the whole rollout"),
        "cost of transport": Measure(
            _ratio(energy, motion["weight"] * np.abs(forward)),
            "",
            "work over weight times distance",
        ),
        "pitch range": Measure(np.ptp(pitch, axis=1), "°", "between its highest and lowest nose"),
        "torso height": Measure(
            motion["height"].mean(axis=1), "m", "of its middle above the ground, mean"
        ),
        "slip ratio": Measure(
            _ratio(motion["slip"].sum(axis=1), path),
            "",
            "slide of the stance feet over path",
        ),
        "duty factor": Measure(
            motion["stance"].mean(axis=(1, 2)),
            "",
            "of the whole time, mean of the feet",
        ),
    }


def _ratio(part: Array, whole: Array) -> Array:
    """Part over whole; infinite where there is no whole."""
    ratio: Array = np.divide(part, whole, out=np.full(len(part), math.inf), where=whole > 0)
    return ratio
