"""Commands on their way to the servos: late, in steps, and on horns that are off."""

import math

import numpy as np

from gaitsim.legged import in_force
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.simulation import FRAME_RATE, Simulation

ROUNDING = 1e-9  # of times that should be whole numbers of steps


def arriving(simulation: Simulation, commands: Floats, first: int, last: int) -> Floats:
    """Return the angles that all servos are told to be at in each physics step.

    Before the first command has arrived, they hold the standing pose.

    Args:
        simulation: of one robot.
        commands: to the servos of the legs, (population, frames, joints) rad, each held for a
            frame.
        first: frame at which the steps begin.
        last: frame with which they end.

    Returns:
        (population, (last − first) · steps + 1, servos) rad.
    """
    late = math.ceil(simulation.latency / simulation.model.opt.timestep - ROUNDING)
    steps = np.arange(first * simulation.steps, last * simulation.steps + 1) - late
    told = np.tile(simulation.rest, (len(commands), len(steps), 1))
    arrived = told[:, np.count_nonzero(steps < 0) :]
    moments = steps[steps >= 0] / simulation.steps
    angles = in_force(commands, moments, FRAME_RATE / simulation.command_rate)
    if simulation.offset.any():
        lower, upper = simulation.model.actuator_ctrlrange[simulation.ctrl].T
        angles = np.clip(angles + simulation.offset, lower, upper)
    arrived[..., simulation.ctrl] = angles
    return told
