"""A robot in a world: the conditions of worlds, and how they change the simulation.

The compiled model is copied and modified. Rebuilding it would take 0.3 to 0.4 times as long as
simulating the second of standing before the start.
"""

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.plugin import Condition
from gaitsim.plugin.toolkit import CONDITIONS, conditions, downward, draw_joint_errors, norm
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.chain import pose_data, sliding
from gaitsim_robot.damaged import is_stuck
from gaitsim_robot.servos import set_servos
from gaitsim_robot.shapes import surfaces
from gaitsim_robot.simulation import FRAME_RATE, Simulation, settle
from gaitsim_robot.terrain import UNEVEN, raise_ground

LATE = 0.03  # s, latency of a slow servo and its controller
WEAKEST = 0.05  # smallest scale factor of torque or speed; weaker servos count as damage


def robot_conditions(friction: float, latency: float) -> Mapping[str, Condition]:
    """Return the conditions of a robot.

    Args:
        friction: nominal friction of the feet.
        latency: nominal latency of the servos, s.
    """
    found = conditions(*CONDITIONS, frame_rate=FRAME_RATE, friction=friction, latency=latency)
    for name in ("servo_torque", "servo_speed"):
        found[name] = replace(found[name], least=WEAKEST)
    return found


def robot_checks(latency: float) -> tuple[Mapping[str, float], ...]:
    """Return worlds with softer contacts, other friction, later, softer and stiffer servos.

    Args:
        latency: nominal latency of the servos, s.
    """
    return (
        {"grip": 1.0},
        {"friction": 0.4},
        {"friction": 1.1},
        {"latency": 0.0 if latency >= LATE else LATE},
        {"servo_stiffness": 0.7},
        {"servo_stiffness": 2.0},
    )


def apply_world(
    simulation: Simulation, world: Mapping[str, float], horns: Floats | None = None
) -> Simulation:
    """Return the simulation of a robot in a world.

    The frame of reference is fixed to the ground: a slope tilts gravity instead. Distances are
    measured along the ground, and heights and tilts relative to it.

    Args:
        simulation: simulation of the robot in its nominal world, with a height field if the world
            is uneven.
        world: values of conditions by name, and optionally `seed`.
        horns: constant error of each leg joint, to which the world's is added, (joints,) rad; None
            for none.
    """
    import mujoco

    model = copy.copy(simulation.model)
    servos = {
        name: replace(
            servo,
            stall_torque=world.get("servo_torque", 1.0) * servo.stall_torque,
            no_load_speed=world.get("servo_speed", 1.0) * servo.no_load_speed,
            stiffness=world.get("servo_stiffness", 1.0) * servo.stiffness,
            damping=world.get("servo_stiffness", 1.0) * servo.damping,
            latency=world.get("latency", servo.latency),
        )
        for name, servo in simulation.servos.items()
    }
    set_servos(model, servos)
    model.opt.impratio = world.get("grip", model.opt.impratio)
    if "friction" in world:
        model.geom_friction[:, 0] = world["friction"]
    model.opt.gravity[:] = norm(model.opt.gravity) * downward(world)
    mass = world.get("mass", 1.0)
    if mass != 1:
        model.body_mass *= mass
        model.body_inertia *= mass
        mujoco.mj_setConst(model, mujoco.MjData(model))
    anatomy = replace(simulation.anatomy, mass=mass * simulation.anatomy.mass)
    ground = None
    if any(world.get(name) for name in UNEVEN):
        feet = np.linalg.norm(lowest_points(model, anatomy.stance)[:, :2], axis=1).max()
        ground = raise_ground(model, world, float(feet))
    turns = ~sliding(model)[model.dof_jntid[simulation.dof]]  # slides have no horns
    offset = draw_joint_errors(world, "joint_offset", len(simulation.ctrl)) * turns
    offset += 0.0 if horns is None else horns
    rest, joints = simulation.rest.copy(), simulation.ctrl
    rest[joints] = np.clip(rest[joints] + offset, *model.actuator_ctrlrange[joints].T)
    start, stands, effort = settle(model, anatomy, rest, simulation.belly, simulation.height)
    found = replace(
        simulation,
        model=model,
        anatomy=anatomy,
        servos=servos,
        start=start,
        stands=stands,
        effort=effort[joints],
        rest=rest,
        offset=offset,
        ground=ground,
        world=world,
    )
    errors = draw_joint_errors(world, "initial_pose", len(joints)) * turns
    return _with_initial_errors(found, errors) if errors.any() else found


def _with_initial_errors(simulation: Simulation, errors: Floats) -> Simulation:
    """Return the simulation of a robot that starts at rest with errors in its initial pose.

    Args:
        simulation: simulation of a standing robot.
        errors: error of each leg joint, (joints,) rad. Stuck joints are not changed; other joints
            are clipped to their limits.
    """
    model, anatomy = simulation.model, simulation.anatomy
    stuck = {one.part for one in simulation.damage if is_stuck(one)}
    errors = np.where([name in stuck for name in anatomy.joints], 0.0, errors)
    start = simulation.start.copy()
    qpos = start[1 : 1 + model.nq]  # a view
    limits = model.actuator_ctrlrange[simulation.ctrl].T
    before = lowest_points(model, qpos)[:, 2].min()
    qpos[simulation.qpos] = np.clip(qpos[simulation.qpos] + errors, *limits)
    qpos[2] += before - lowest_points(model, qpos)[:, 2].min()
    return replace(simulation, start=start)


def lowest_points(model: Any, qpos: Floats) -> Floats:
    """Return the lowest point of each ball of a robot's surface, (points, 3) m."""
    surface = surfaces(model)
    points = surface.place(pose_data(model, qpos))
    points[:, 2] -= surface.radius
    of_robot: Floats = points[surface.bodies > 0]
    return of_robot
