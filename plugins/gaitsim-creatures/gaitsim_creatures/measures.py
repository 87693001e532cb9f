"""Measures of creatures: how they travel, and what their bodies are like.

Limbs and proportion: Miras, Haasdijk, Glette and Eiben 2018, "Search space analysis of evolvable
robot morphologies".
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Measure, Motion
from gaitsim.plugin.toolkit import STRIDE_FREQUENCY
from gaitsim_creatures.trees import BRICK, HINGE, Bodies, Floats
from gaitsim_robot.measures import travel_measures


def creature_measures(
    motion: Motion, bodies: Bodies, rows: NDArray[np.intp]
) -> Mapping[str, Measure]:
    """Return measures of a population.

    Args:
        motion: motion of the population.
        bodies: grown bodies.
        rows: row of each individual's body, (population,).
    """
    kinds = bodies.modules[..., 0]
    hinges = (kinds == HINGE).sum(axis=1)[rows]
    yaw = motion["orientation"][..., 2]
    travel = travel_measures(motion)
    speed = travel["body lengths"].values / np.maximum(motion["lasted"], 1e-9)
    # A body has one segment more than hinges; others in the channel are empty.
    touching = motion["stance"].mean(axis=1).sum(axis=1) / (hinges + 1)
    return {
        **travel,
        "relative speed": Measure(speed, "1/s", "body lengths travelled per second"),
        "stride frequency": Measure(motion[STRIDE_FREQUENCY], "Hz", "frequency of the oscillators"),
        "yaw": Measure(np.degrees(yaw[:, -1] - yaw[:, 0]), "°", "turn to the left at the end"),
        "ground contact": Measure(
            touching, "", "share of the body's segments that touch the ground, averaged over time"
        ),
        "modules": Measure(
            (bodies.counts[rows] - 1).astype(np.float64), "", "number of modules besides the core"
        ),
        "hinges": Measure(hinges.astype(np.float64), "", "number of hinges"),
        "limbs": Measure(limbs(bodies)[rows], "", "number of modules at the ends of the tree"),
        "proportion": Measure(
            proportion(bodies)[rows],
            "",
            "smaller by larger horizontal extent of the body: 1 is as wide as it is long",
        ),
    }


def limbs(bodies: Bodies) -> Floats:
    """Return the number of modules without children, (bodies,)."""
    found = np.zeros(len(bodies.counts))
    for row, count in enumerate(bodies.counts):
        parents = {*bodies.modules[row, :count, 1].tolist()}
        found[row] = count - 1 - len(parents - {-1, 0})
    return found


def proportion(bodies: Bodies) -> Floats:
    """Return the smaller horizontal extent divided by the larger one, (bodies,)."""
    low = (bodies.places - bodies.halves)[..., :2].min(axis=1)
    high = (bodies.places + bodies.halves)[..., :2].max(axis=1)
    extents = high - low
    found: Floats = extents.min(axis=1) / extents.max(axis=1)
    return found


def describe_bodies(bodies: Bodies) -> Mapping[str, str]:
    """Return the parts, limbs and proportion of the first body."""
    kinds = bodies.modules[0, :, 0]
    bricks, hinges = int((kinds == BRICK).sum()), int((kinds == HINGE).sum())
    return {
        "parts": f"1 core, {bricks} bricks, {hinges} hinges",
        "limbs": f"{limbs(bodies)[0]:g}",
        "proportion": f"{proportion(bodies)[0]:.2f}",
    }
