"""Conditions that several bodies have, by one name and meaning, and what a world's seed draws."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import SEED, Condition

CONDITIONS: Mapping[str, Condition] = {
    "friction": Condition("", 1.0, 0.3, 1.2, 0.0, 5.0, "friction of the feet on the ground"),
    "mass": Condition("", 1.0, 0.8, 1.2, 0.1, 10.0, "share of all masses"),
    "latency": Condition("s", 0.0, 0.0, 0.05, 0.0, 1.0, "of the servos, from a command"),
    "servo_torque": Condition("", 1.0, 0.7, 1.0, 0.0, 10.0, "share of the servos' torque"),
    "servo_speed": Condition("", 1.0, 0.7, 1.0, 0.0, 10.0, "share of the servos' speed"),
    "joint_offset": Condition(
        "°", 0.0, 0.0, 2.0, 0.0, 30.0, "standard deviation of what each joint is off for good"
    ),
    "slope": Condition("°", 0.0, -3.0, 3.0, -45.0, 45.0, "of the ground, uphill"),
    "side_slope": Condition("°", 0.0, -3.0, 3.0, -45.0, 45.0, "of the ground, up to the left"),
    "unevenness": Condition("m", 0.0, 0.0, 0.02, 0.0, 0.2, "height of the highest bumps"),
    "push": Condition(
        "m/s", 0.0, 0.0, 0.3, 0.0, 10.0, "sudden change of the body's velocity, at some moment"
    ),
    "initial_pose": Condition(
        "°", 0.0, 0.0, 3.0, 0.0, 30.0, "standard deviation of what each joint is off at the start"
    ),
}
"""By name; a body has those that mean something for it, and `command_rate` if it has servos."""


def conditions(
    *names: str, frame_rate: float | None = None, **nominal: float
) -> dict[str, Condition]:
    """Return conditions of a body by name.

    Args:
        names: from `CONDITIONS`.
        frame_rate: at which commands arrive in the nominal world, Hz; adds `command_rate`.
        nominal: values in the body's nominal world, by name, where they are its own.
    """
    found = {
        name: replace(CONDITIONS[name], nominal=nominal.get(name, CONDITIONS[name].nominal))
        for name in names
    }
    if frame_rate is not None:
        found["command_rate"] = Condition(
            "Hz", frame_rate, frame_rate / 2, frame_rate, 1.0, 1000.0, "at which commands arrive"
        )
    return found


_STREAMS = {"joint_offset": 2, "initial_pose": 3, "push": 4, "wind": 5}  # 0 and 1 draw the ground

_Drawn = Literal["joint_offset", "initial_pose", "push", "wind"]


def stream(world: Mapping[str, float], name: _Drawn) -> np.random.Generator:
    """Return the random numbers of a condition, a function of the world's seed alone."""
    return np.random.default_rng([seed_of(world), _STREAMS[name]])


def seed_of(world: Mapping[str, float]) -> int:
    """Return the seed of a world; 0 where it has none."""
    return int(world.get(SEED, 0))


def joint_errors(
    world: Mapping[str, float], name: Literal["joint_offset", "initial_pose"], joints: int
) -> NDArray[np.float64]:
    """Return how far each joint is off, (joints,) rad, drawn from the world's seed.

    Args:
        world: values by the names of conditions; without `name`, no joint is off.
        name: of the condition, a standard deviation in degrees.
        joints: how many.
    """
    spread = np.radians(world.get(name, 0.0))
    return np.asarray(spread * stream(world, name).standard_normal(joints))


def drawn_push(world: Mapping[str, float], frames: int) -> tuple[int, float]:
    """Return when and where a push goes, drawn from the world's seed.

    Returns:
        The frame after which the body's velocity changes, in the middle three fifths of the
        motion, and the direction of the push, rad to the left from forward.
    """
    when, where = stream(world, "push").random(2)
    return round((0.2 + 0.6 * when) * (frames - 1)), float(2 * np.pi * where)
