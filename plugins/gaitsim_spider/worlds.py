"""Conditions of the spider's world, which change its commands and the mass of its legs.

The kinematic spider has no forces, so friction, torque and slope are not among them.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Condition
from gaitsim.encoding import limit_steps
from gaitsim.legged import conditions, delay_angles, draw_joint_errors, hold_commands
from gaitsim_spider import body

LEG_MASS = "leg_mass"

CONDITIONS: Mapping[str, Condition] = {
    **conditions(
        "latency", "servo_speed", "joint_offset", "initial_pose", frame_rate=body.FRAME_RATE
    ),
    LEG_MASS: Condition(
        "", 1.0, 0.8, 1.2, 0.0, 10.0, "scale factor of the legs' masses (moves the centre of mass)"
    ),
}


def joint_positions(
    commands: NDArray[np.float32], world: Mapping[str, float], step_limits: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the positions of joints that follow commands in a world.

    Each command is held until the next one arrives, after the latency. The servos have a limited
    speed and constant errors, and stay within ±30°. In the nominal world, returns `commands`
    itself.

    Args:
        commands: commanded angles, (population, joints, frames) rad.
        world: values by the names of conditions.
        step_limits: largest rotation of each joint per frame at full speed, (joints,) rad.

    Returns:
        (population, joints, frames) rad.
    """
    values = {**_NOMINAL, **{name: world[name] for name in _NOMINAL if name in world}}
    if values == _NOMINAL:
        return commands
    joints = commands.shape[1]
    by_frame = np.ascontiguousarray(commands.swapaxes(1, 2))
    sent = hold_commands(by_frame, body.FRAME_RATE, values["command_rate"])
    arrived = delay_angles(sent, values["latency"] * body.FRAME_RATE).swapaxes(1, 2).copy()
    arrived[..., 0] += draw_joint_errors(world, "initial_pose", joints)
    turned = limit_steps(arrived, values["servo_speed"] * step_limits)
    turned += draw_joint_errors(world, "joint_offset", joints).astype(turned.dtype)[:, None]
    limit = np.float32(body.ANGLE_LIMIT)
    return np.asarray(np.clip(turned, -limit, limit, out=turned), np.float32)


_NOMINAL = {name: one.nominal for name, one in CONDITIONS.items() if name != LEG_MASS}
