"""Conditions of the fly's world, and the random draws from the world's seed."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Condition
from gaitsim.legged import condition_rng, conditions, draw_joint_errors, draw_push
from gaitsim.portable import cos, sin


def fly_conditions(air_density: float) -> dict[str, Condition]:
    """Return the conditions of a fly by name; `air_density` is the nominal density, kg/m³."""
    own = conditions("mass", "latency", "servo_speed", "joint_offset", "push")
    return {
        **own,
        "latency": replace(own["latency"], high=0.02),
        "air_density": Condition(
            "kg/m³",
            air_density,
            0.85 * air_density,
            1.1 * air_density,
            0.0,
            10 * air_density,
            "density of the air",
        ),
        "wind": Condition("m/s", 0.0, 0.0, 1.0, 0.0, 30.0, "steady horizontal wind"),
    }


def wing_offsets(world: Mapping[str, float], *, planar: bool) -> NDArray[np.float64]:
    """Return the constant error of each wing angle, (6,) rad.

    Args:
        world: values by the names of conditions.
        planar: whether both wings get the same errors, as wings with equal commands cannot
            correct a difference.
    """
    drawn = draw_joint_errors(world, "joint_offset", 6)
    return np.tile(drawn[:3], 2) if planar else drawn


def wind(world: Mapping[str, float], *, planar: bool) -> tuple[float, float]:
    """Return the velocity of the air along x and y, m/s; only along x if `planar`."""
    direction = 2 * math.pi * float(condition_rng(world, "wind").random())
    return _horizontal(world.get("wind", 0.0), direction, planar)


def push(
    world: Mapping[str, float], frames: int, *, planar: bool
) -> tuple[int, NDArray[np.float64]]:
    """Return the frame of a push and its change of the velocity, (3,) m/s."""
    frame, direction = draw_push(world, frames)
    return frame, np.array([*_horizontal(world.get("push", 0.0), direction, planar), 0.0])


def _horizontal(size: float, direction: float, planar: bool) -> tuple[float, float]:
    if planar:
        return math.copysign(size, cos(direction)), 0.0
    return size * float(cos(direction)), size * float(sin(direction))
