"""Transmission of commands to the servos: latency, command rate and offsets of the joints."""

import math

import numpy as np

from gaitsim.legged import commands_at
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.simulation import FRAME_RATE, Simulation

ROUNDING = 1e-9  # steps, tolerance for rounding errors of whole steps


def delayed_commands(simulation: Simulation, commands: Floats, first: int, last: int) -> Floats:
    """Return the commanded angles of all servos in each physics step.

    Servos hold the standing pose until the first command arrives.

    Args:
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
        first: frame at the start of the steps.
        last: frame at the end of the steps.

    Returns:
        The angles, (population, (last − first) · steps + 1, servos) rad.
    """
    late = math.ceil(simulation.latency / simulation.model.opt.timestep - ROUNDING)
    steps = np.arange(first * simulation.steps, last * simulation.steps + 1) - late
    commanded = np.tile(simulation.rest, (len(commands), len(steps), 1))
    arrived = commanded[:, np.count_nonzero(steps < 0) :]
    moments = steps[steps >= 0] / simulation.steps
    angles = commands_at(commands, moments, FRAME_RATE / simulation.command_rate)
    if simulation.offset.any():
        lower, upper = simulation.model.actuator_ctrlrange[simulation.ctrl].T
        angles = np.clip(angles + simulation.offset, lower, upper)
    arrived[..., simulation.ctrl] = angles
    return commanded
