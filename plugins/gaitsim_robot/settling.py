"""Let a robot stand for a while before its start."""

import copy
from typing import Any

import numpy as np

from gaitsim_robot.anatomy import Floats
from gaitsim_robot.sums import ratio

TIPPED = 0.5  # cosine of the trunk's tilt, 60°, beyond which the robot has fallen
SUNK = 0.8  # share of the standing height; a robot with a lower trunk does not stand
SETTLE = 1.0  # s, duration of standing before the start
STILL = 0.2  # standing heights per second; after a second, a falling trunk is faster
STRONG = 100.0  # factor on the torque of servos, to measure the torque that standing requires
_VOLTAGE = 7  # index of the largest voltage in the gains of MuJoCo's dcmotor


def settle(
    model: Any, stance: Floats, rest: Floats, belly: int, height: float
) -> tuple[Floats, bool, Floats]:
    """Let a robot stand for a while.

    Args:
        model: MuJoCo's compiled model.
        stance: initial pose, (nq,).
        rest: control of all servos, (servos,).
        belly: sensor index of the number of contacts between trunk and ground.
        height: height of the intact robot's trunk when standing, m.

    Returns:
        The state at rest, whether the robot stands, and the share of its stall torque that each
        servo needs, (servos,). `Simulation` has them as `start`, `stands` and `effort`.
    """
    import mujoco

    settled, stands = _simulate_standing(model, stance, rest, belly, height)
    needed = settled.actuator_force
    if not stands:
        strong = copy.copy(model)
        strong.actuator_forcerange *= STRONG
        strong.actuator_gainprm[:, _VOLTAGE] *= STRONG
        needed = _simulate_standing(strong, stance, rest, belly, height)[0].actuator_force
    start = _at_rest(model, settled.qpos if stands else stance, rest)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, start, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state, stands, ratio(np.abs(needed), model.actuator_forcerange[:, 1])


def _simulate_standing(
    model: Any, stance: Floats, rest: Floats, belly: int, height: float
) -> tuple[Any, bool]:
    """Return the robot after standing for a while, and whether it still stands.

    A standing robot is upright and still, and not far below `height`, m.
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
    """Return the robot at rest at time 0, with `rest` as control of its servos."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.ctrl[:] = rest
    return data
