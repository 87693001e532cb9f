"""The motion of a population of robots, computed from their record."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion
from gaitsim.portable import arcsin, arctan2, norm
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.rollout import Record, RollOut, roll_out
from gaitsim_robot.simulation import FRAME_RATE, Simulation


def walk(simulation: Simulation, commands: Floats, engine: RollOut = roll_out) -> Motion:
    """Return the motion of robots whose servos follow commands.

    Args:
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad.
        engine: function that simulates the robots.
    """
    record = engine(simulation, commands)
    held = commands.copy()
    for individual in np.flatnonzero(record.lasted < commands.shape[1]):
        lasted = record.lasted[individual]
        held[individual, lasted:] = held[individual, max(lasted - 1, 0)]
    qpos, qvel = record.qpos, record.qvel
    torso = qpos[..., :3] - np.array([*simulation.start[1:3], 0.0])
    record.load[:, 0] = record.load[:, 1]  # the robot is standing before the start
    stance = record.load[..., 2] > 0
    return Motion(
        FRAME_RATE,
        {
            "joint_angles": held,
            "joint_positions": qpos[..., simulation.qpos],
            "joint_velocities": qvel[..., simulation.dof],
            "torque": record.torque,
            "stall_torque": np.tile(simulation.stall_torque, (len(commands), 1)),
            "torso": torso,
            "torso_velocity": qvel[..., :3],
            "orientation": orientation(simulation.turn(qpos[..., 3:7])),
            "height": simulation.above(qpos),
            "foot_positions": record.feet - np.array([*simulation.start[1:3], 0.0]),
            "stance": stance,
            "load": record.load,
            "slip": _slip(record, stance),
            "energy": record.work,
            "lasted": np.maximum(record.lasted - 1, 0) / FRAME_RATE,
            "weight": np.full(len(commands), _weight(simulation)),
            "length": np.full(len(commands), simulation.anatomy.length),
            "configuration": qpos,
        },
        failures=record.failures,
    )


def _weight(simulation: Simulation) -> float:
    """Return the weight of the whole robot, N."""
    return simulation.anatomy.mass * float(norm(simulation.model.opt.gravity))


def _slip(record: Record, stance: NDArray[np.bool_]) -> Floats:
    """Return the mean slide of stance feet since the previous frame, (population, frames) m."""
    slid = np.where(stance, record.slide, 0.0).sum(axis=2)
    slip: Floats = slid / np.maximum(stance.sum(axis=2), 1)
    return slip


def orientation(turn: Floats) -> Floats:
    """Return roll, pitch and yaw relative to the standing pose, (population, frames, 3) rad.

    Positive roll is to the right, positive pitch nose down, and positive yaw to the left. Yaw is
    continuous over whole turns.
    """
    w, x, y, z = np.moveaxis(turn, -1, 0)
    roll = arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.unwrap(arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), axis=1)
    return np.stack([roll, pitch, yaw], axis=-1)
