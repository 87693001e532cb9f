"""A robot that stands for a while before its start."""

import copy
from typing import Any

import numpy as np

from gaitsim_robot.anatomy import Floats
from gaitsim_robot.sums import ratio

TIPPED = 0.5  # cosine of the trunk's tilt beyond which it has fallen: 60°
SUNK = 0.8  # share of the standing height below which it does not stand
SETTLE = 1.0  # s, how long the robot stands before its start
STILL = 0.2  # standing heights a second, of the trunk; what falls over is faster after a second
STRONG = 100.0  # times their torque, servos that show what standing needs
_VOLTAGE = 7  # index of the largest voltage in the gains of MuJoCo's dcmotor


def stand(
    model: Any, stance: Floats, rest: Floats, belly: int, height: float
) -> tuple[Floats, bool, Floats]:
    """Let a robot stand for a while.

    Args:
        model: MuJoCo's compiled model.
        stance: where it starts, (nq,).
        rest: control of all servos, (servos,).
        belly: index of the number of contacts of the trunk with the ground.
        height: of the trunk of the intact robot in standing, m.

    Returns:
        Its state at rest, whether it stands, and the share of its torque that each servo needs, as
        `Simulation` has them, but for all servos.
    """
    import mujoco

    settled, stands = _settled(model, stance, rest, belly, height)
    needed = settled.actuator_force
    if not stands:
        strong = copy.copy(model)
        strong.actuator_forcerange *= STRONG
        strong.actuator_gainprm[:, _VOLTAGE] *= STRONG
        needed = _settled(strong, stance, rest, belly, height)[0].actuator_force
    start = _at_rest(model, settled.qpos if stands else stance, rest)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, start, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state, stands, ratio(np.abs(needed), model.actuator_forcerange[:, 1])


def _settled(
    model: Any, stance: Floats, rest: Floats, belly: int, height: float
) -> tuple[Any, bool]:
    """Return the robot after it has stood for a while, and whether it is still up.

    Up is upright, still, and not far below `height`, m, that of the intact robot.
    """
    import mujoco

    data = _at_rest(model, stance, rest)
    mujoco.mj_step(model, data, round(SETTLE / model.opt.timestep))
    standing = np.empty(9)
    mujoco.mju_quat2Mat(standing, stance[3:7])
    upright = data.xmat[1, 6:] @ standing[6:] > TIPPED and data.qpos[2] > SUNK * height
    still = np.linalg.norm(data.qvel[:3]) < STILL * height
    return data, bool(upright and still and data.sensordata[belly] == 0)


def _at_rest(model: Any, qpos: Floats, rest: Floats) -> Any:
    """Return the robot at rest at time 0, its servos commanded to the standing pose."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.ctrl[:] = rest
    return data
