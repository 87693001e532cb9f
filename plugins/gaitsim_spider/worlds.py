"""Conditions of the spider's world: what becomes of its commands, and how heavy its legs are.

Friction, torque and slope need forces, which its kinematics does without.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Condition
from gaitsim.encoding import limit_steps
from gaitsim.legged import conditions, delayed, held, joint_errors
from gaitsim_spider import body

LEG_MASS = "leg_mass"

CONDITIONS: Mapping[str, Condition] = {
    **conditions(
        "latency", "servo_speed", "joint_offset", "initial_pose", frame_rate=body.FRAME_RATE
    ),
    LEG_MASS: Condition(
        "", 1.0, 0.8, 1.2, 0.0, 10.0, "share of the legs' masses, which shift the centre of mass"
    ),
}


def joint_positions(
    commands: NDArray[np.float32], world: Mapping[str, float], step_limits: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return where joints are that follow commands in a world.

    Commands are held, arrive late, and are followed by servos of limited speed, whose angles are
    off and within ±30°. Of a nominal world, `commands` itself.

    Args:
        commands: (population, joints, frames) rad.
        world: values by the names of conditions.
        step_limits: how far each joint can turn in a frame at full speed, (joints,) rad.

    Returns:
        (population, joints, frames) rad.
    """
    told = {**_NOMINAL, **{name: world[name] for name in _NOMINAL if name in world}}
    if told == _NOMINAL:
        return commands
    joints = commands.shape[1]
    by_frame = np.ascontiguousarray(commands.swapaxes(1, 2))
    sent = held(by_frame, body.FRAME_RATE, told["command_rate"])
    arrived = delayed(sent, told["latency"] * body.FRAME_RATE).swapaxes(1, 2).copy()
    arrived[..., 0] += joint_errors(world, "initial_pose", joints)
    turned = limit_steps(arrived, told["servo_speed"] * step_limits)
    turned += joint_errors(world, "joint_offset", joints).astype(turned.dtype)[:, None]
    limit = np.float32(body.ANGLE_LIMIT)
    return np.asarray(np.clip(turned, -limit, limit, out=turned), np.float32)


_NOMINAL = {name: one.nominal for name, one in CONDITIONS.items() if name != LEG_MASS}
