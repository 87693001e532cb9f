"""Commands on their way to the servos: late, in steps, and on horns that are off."""

import math

import numpy as np

from gaitsim_robot.anatomy import Floats
from gaitsim_robot.simulation import FRAME_RATE, Simulation

ROUNDING = 1e-9  # of times that should be whole numbers of steps or frames


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
    dt, frames = simulation.model.opt.timestep, commands.shape[1]
    late = math.ceil(simulation.latency / dt - ROUNDING)
    steps = np.arange(first * simulation.steps, last * simulation.steps + 1) - late
    told = np.tile(simulation.rest, (len(commands), len(steps), 1))
    arrived = told[:, np.count_nonzero(steps < 0) :]
    # A controller slower than the frames reads the gait between them.
    rate = simulation.command_rate
    place = np.floor(steps[steps >= 0] * (dt * rate) + ROUNDING) * (FRAME_RATE / rate)
    frame = np.floor(place + ROUNDING).astype(np.intp)
    share = np.maximum(place - frame, 0.0)
    angles = commands[:, frame]
    if (share > ROUNDING).any():
        following = commands[:, np.minimum(frame + 1, frames - 1)]
        angles += share[:, None] * (following - angles)
    if simulation.offset.any():
        lower, upper = simulation.model.actuator_ctrlrange[simulation.ctrl].T
        angles = np.clip(angles + simulation.offset, lower, upper)
    arrived[..., simulation.ctrl] = angles
    return told
