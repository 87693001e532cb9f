"""A robot in a world: what may vary between worlds, and how that changes its simulation.

The compiled model is copied and changed rather than compiled anew, which takes about as long again
as the second that a robot stands before its start.
"""

import copy
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gaitsim.contracts import Condition
from gaitsim.contracts.condition import SEED
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.servos import set_limits
from gaitsim_robot.simulation import Simulation, stand

STEEPEST = 30.0  # °, of slopes: half of the tilt at which a trunk has fallen

CONDITIONS: Mapping[str, Condition] = {
    "friction": Condition("", 0.8, 0.3, 1.2, 0.0, 5.0, "of the feet on the ground"),
    "mass": Condition("", 1.0, 0.8, 1.2, 0.1, 10.0, "share of the masses of all parts"),
    "latency": Condition("s", 0.0, 0.0, 0.05, 0.0, 0.2, "of the servos, in place of their own"),
    "servo_torque": Condition("", 1.0, 0.7, 1.0, 0.05, 10.0, "share of the servos' torque"),
    "servo_speed": Condition("", 1.0, 0.7, 1.0, 0.05, 10.0, "share of the servos' speed"),
    "slope": Condition("°", 0.0, -3.0, 3.0, -STEEPEST, STEEPEST, "of the ground, uphill forward"),
    "side_slope": Condition(
        "°", 0.0, -3.0, 3.0, -STEEPEST, STEEPEST, "of the ground, up to the left"
    ),
    # A horn on a spline of 25 teeth, as on the MG995, goes on in steps of 14.4°; what is left after
    # trimming by eye, and the play of the gears, is about 1°.
    "joint_offset": Condition(
        "°", 0.0, 0.0, 2.0, 0.0, 30.0, "standard deviation of how far each joint's horn is off"
    ),
}
"""Conditions with the nominal values of a robot without own options."""


def conditions(friction: float, latency: float) -> Mapping[str, Condition]:
    """Return what may vary between the worlds of a robot.

    Args:
        friction: of its feet where no world tells it.
        latency: of its servos there, s.
    """
    nominal = {"friction": friction, "latency": latency}
    return {
        name: replace(one, nominal=nominal.get(name, one.nominal))
        for name, one in CONDITIONS.items()
    }


def in_world(simulation: Simulation, world: Mapping[str, float]) -> Simulation:
    """Return a robot in a world.

    The frame of reference is that of the ground: on a slope, gravity turns. Distances are along
    the ground, and heights and tilts count from it.

    Args:
        simulation: of the robot in its nominal world.
        world: values of conditions by name, and perhaps `seed`.
    """
    import mujoco

    told = {name: one.nominal for name, one in CONDITIONS.items()} | dict(world)
    model = copy.copy(simulation.model)
    anatomy = replace(simulation.anatomy, mass=told["mass"] * simulation.anatomy.mass)
    if "friction" in world:
        model.geom_friction[:, 0] = world["friction"]
    servos = {
        name: replace(
            servo,
            stall_torque=told["servo_torque"] * servo.stall_torque,
            no_load_speed=told["servo_speed"] * servo.no_load_speed,
            latency=world.get("latency", servo.latency),
        )
        for name, servo in simulation.servos.items()
    }
    set_limits(model, servos)
    down = downward(told["slope"], told["side_slope"])
    model.opt.gravity[:] = np.linalg.norm(model.opt.gravity) * down
    if told["mass"] != 1:
        model.body_mass *= told["mass"]
        model.body_inertia *= told["mass"]
        mujoco.mj_setConst(model, mujoco.MjData(model))
    offset = math.radians(told["joint_offset"]) * _stream(world, "joint_offset").standard_normal(
        len(simulation.ctrl)
    )
    rest = simulation.rest.copy()
    lower, upper = model.actuator_ctrlrange[simulation.ctrl].T
    rest[simulation.ctrl] = np.clip(rest[simulation.ctrl] + offset, lower, upper)
    start, stands, effort = stand(model, anatomy.stance, rest, simulation.belly, simulation.height)
    return replace(
        simulation,
        model=model,
        anatomy=anatomy,
        servos=servos,
        start=start,
        stands=stands,
        effort=effort[simulation.ctrl],
        rest=rest,
        offset=offset,
        latency=world.get("latency", simulation.latency),
    )


def downward(slope: float, side_slope: float) -> Floats:
    """Return the direction of gravity seen from a slope, (3,).

    Args:
        slope: of the x axis above the horizontal, °.
        side_slope: the same of the y axis, about the x axis, °.
    """
    along, aside = math.radians(slope), math.radians(side_slope)
    level = math.cos(along)
    return -np.array([math.sin(along), level * math.sin(aside), level * math.cos(aside)])


def _stream(world: Mapping[str, float], condition: str) -> np.random.Generator:
    """Return the random numbers of a condition, whatever else there is in the world."""
    return np.random.default_rng([int(world.get(SEED, 0)), *condition.encode()])
