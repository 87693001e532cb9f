"""A robot's drawing over time: its solids, and line segments from joint to joint."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim.contracts.quaternions import product, rotated
from gaitsim.legged import Damage
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.figure import TRUNK, figure, placed
from gaitsim_robot.inclined import on_ground
from gaitsim_robot.simulation import Simulation


def skeleton(simulation: Simulation, motion: Motion, individual: int) -> Skeleton:
    """Return the body of one individual over time, on the ground of its world."""
    level = drawn(
        simulation.model,
        simulation.anatomy,
        motion["configuration"][individual],
        motion["stance"][individual],
        motion.frame_rate,
        simulation.start[1:3],
        simulation.damage,
    )
    return on_ground(level, simulation)


def drawn(
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
    places, turns = placed(model, configuration)
    places[..., :2] -= start
    shown = figure(model, anatomy, damage)
    bodies, owners, feet = list(shown.bodies), list(shown.owners), list(shown.feet)
    poses = np.concatenate(
        [
            places[:, owners] + rotated(turns[:, owners], shown.offsets[:, :3]),
            product(turns[:, owners], shown.offsets[:, 3:]),
        ],
        axis=-1,
    )
    return Skeleton(
        places[:, bodies, None] + rotated(turns[:, bodies, None], shown.segments),
        shown.names,
        frame_rate,
        contacts=places[:, feet] + rotated(turns[:, feet], shown.soles),
        touching=touching,
        contact_names=tuple(leg.name for leg in anatomy.legs),
        centre=places[:, TRUNK],
        solids=shown.solids,
        poses=poses if shown.solids else None,
        damaged=shown.damaged,
    )
