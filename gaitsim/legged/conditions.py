"""Conditions shared by several bodies, and the random draws from a world's seed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import SEED, Condition
from gaitsim.portable import standard_normal

CONDITIONS: Mapping[str, Condition] = {
    "friction": Condition("", 1.0, 0.3, 1.2, 0.0, 5.0, "friction of the feet on the ground"),
    "mass": Condition("", 1.0, 0.8, 1.2, 0.1, 10.0, "scale factor of all masses"),
    "latency": Condition("s", 0.0, 0.0, 0.05, 0.0, 1.0, "delay of the servos after a command"),
    "servo_torque": Condition("", 1.0, 0.7, 1.0, 0.0, 10.0, "scale factor of the servos' torque"),
    "servo_speed": Condition("", 1.0, 0.7, 1.0, 0.0, 10.0, "scale factor of the servos' speed"),
    "servo_stiffness": Condition(
        "", 1.0, 0.7, 2.0, 0.1, 10.0, "stiffness of the servos, as a factor"
    ),
    "grip": Condition(
        "", 10.0, 1.0, 10.0, 0.1, 100.0, "hardness of friction in the model of contacts"
    ),
    "joint_offset": Condition(
        "°", 0.0, 0.0, 2.0, 0.0, 30.0, "standard deviation of each joint's constant error"
    ),
    "slope": Condition("°", 0.0, -3.0, 3.0, -45.0, 45.0, "slope of the ground, uphill"),
    "side_slope": Condition(
        "°", 0.0, -3.0, 3.0, -45.0, 45.0, "sideways slope of the ground, up to the left"
    ),
    "unevenness": Condition("m", 0.0, 0.0, 0.02, 0.0, 0.2, "height of the highest bumps"),
    "steps": Condition(
        "m",
        0.0,
        0.0,
        0.03,
        0.0,
        0.2,
        "height of the steps up or down between terraces along x",
        drawn=False,
    ),
    "rubble": Condition(
        "m", 0.0, 0.0, 0.03, 0.0, 0.2, "height of the highest blocks of rubble", drawn=False
    ),
    "push": Condition(
        "m/s", 0.0, 0.0, 0.3, 0.0, 10.0, "sudden change of the body's velocity at a random time"
    ),
    "initial_pose": Condition(
        "°", 0.0, 0.0, 3.0, 0.0, 30.0, "standard deviation of each joint's error at the start"
    ),
}
"""Conditions by name. A body supports a selection of them, and `command_rate` if it has servos."""


def conditions(
    *names: str, frame_rate: float | None = None, **nominal: float
) -> dict[str, Condition]:
    """Return conditions of a body by name.

    Args:
        names: names in `CONDITIONS`.
        frame_rate: command rate in the nominal world, Hz, for the condition `command_rate`; None
            for a body without this condition.
        nominal: nominal values by name, which replace the values in `CONDITIONS`.
    """
    found = {
        name: replace(CONDITIONS[name], nominal=nominal.get(name, CONDITIONS[name].nominal))
        for name in names
    }
    if frame_rate is not None:
        found["command_rate"] = Condition(
            "Hz", frame_rate, frame_rate / 2, frame_rate, 1.0, 1000.0, "rate of the commands"
        )
    return found


_RandomCondition = Literal[
    "joint_offset", "initial_pose", "push", "wind", "steps", "rubble", "sensors"
]

# 0 and 1 draw the bumps. The order of the names is part of the results.
_STREAMS = {name: stream for stream, name in enumerate(get_args(_RandomCondition), start=2)}


def condition_rng(world: Mapping[str, float], name: _RandomCondition) -> np.random.Generator:
    """Return the random generator of a condition, seeded by the world's seed alone."""
    return np.random.default_rng([world_seed(world), _STREAMS[name]])


def world_seed(world: Mapping[str, float]) -> int:
    """Return the seed of a world; 0 if it has none."""
    return int(world.get(SEED, 0))


def draw_joint_errors(
    world: Mapping[str, float], name: Literal["joint_offset", "initial_pose"], joints: int
) -> NDArray[np.float64]:
    """Draw the error of each joint's angle, (joints,) rad, from the world's seed.

    Args:
        world: values by the names of conditions; without `name`, all errors are 0.
        name: name of the condition, a standard deviation in degrees.
        joints: number of joints.
    """
    spread = np.radians(world.get(name, 0.0))
    return np.asarray(spread * standard_normal(condition_rng(world, name), joints))


def draw_push(world: Mapping[str, float], frames: int) -> tuple[int, float]:
    """Draw the moment and the direction of a push from the world's seed.

    Returns:
        The frame after which the body's velocity changes, between 20 % and 80 % of the motion,
        and the direction of the push, rad to the left of forward.
    """
    moment, turn = condition_rng(world, "push").random(2)
    return round((0.2 + 0.6 * moment) * (frames - 1)), float(2 * np.pi * turn)
