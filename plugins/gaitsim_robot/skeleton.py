"""A robot's drawing over time: its solids, and line segments from joint to joint."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim.contracts.quaternions import product, rotated
from gaitsim.legged import Damage
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.figure import TRUNK, body_poses, figure
from gaitsim_robot.inclined import place_on_ground
from gaitsim_robot.simulation import Simulation


def skeleton(simulation: Simulation, motion: Motion, individual: int) -> Skeleton:
    """Return the body of one individual over time, on the ground of its world."""
    level = robot_skeleton(
        simulation.model,
        simulation.anatomy,
        motion["configuration"][individual],
        motion["stance"][individual],
        motion.frame_rate,
        simulation.start[1:3],
        simulation.damage,
    )
    return place_on_ground(level, simulation)


def robot_skeleton(
    model: Any,
    anatomy: Anatomy,
    configuration: Floats,
    touching: Any,
    frame_rate: float,
    start: Floats,
    damage: Sequence[Damage] = (),
) -> Skeleton:
    """Return a robot's body over time.

    Args:
        model: MuJoCo's compiled model.
        anatomy: anatomy of the robot.
        configuration: positions of the trunk and all joints, (frames, nq).
        touching: whether each foot touches the ground, (frames, feet) bool.
        frame_rate: frames per second, Hz.
        start: x and y of the point that becomes the origin, (2,) m.
        damage: damage of the robot; lost legs are omitted.
    """
    places, turns = body_poses(model, configuration)
    places[..., :2] -= start
    drawing = figure(model, anatomy, damage)
    bodies, owners, feet = list(drawing.bodies), list(drawing.owners), list(drawing.feet)
    poses = np.concatenate(
        [
            places[:, owners] + rotated(turns[:, owners], drawing.offsets[:, :3]),
            product(turns[:, owners], drawing.offsets[:, 3:]),
        ],
        axis=-1,
    )
    return Skeleton(
        places[:, bodies, None] + rotated(turns[:, bodies, None], drawing.segments),
        drawing.names,
        frame_rate,
        contacts=places[:, feet] + rotated(turns[:, feet], drawing.soles),
        touching=touching,
        contact_names=tuple(leg.name for leg in anatomy.legs),
        centre=places[:, TRUNK],
        solids=drawing.solids,
        poses=poses if drawing.solids else None,
        damaged=drawing.damaged,
    )
