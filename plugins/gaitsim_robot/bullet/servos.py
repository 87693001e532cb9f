"""Torques of the servos, springs and dampers of a compiled robot."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.anatomy import Floats


class Drives:
    """The drives of a robot's joints, with servos as in `gaitsim_robot.servos`.

    Args:
        model: MuJoCo's compiled model.
        joints: numbers of hinges and slides, (joints,).

    Attributes:
        stiffness: total stiffness of servos and springs, (joints,) N m/rad.
        damping: total damping of servos and joints, (joints,) N m s/rad.
    """

    def __init__(self, model: Any, joints: NDArray[np.intp]) -> None:
        actuators = {int(joint): n for n, joint in enumerate(model.actuator_trnid[:, 0])}
        self._servo = np.array([actuators.get(int(joint), -1) for joint in joints], np.intp)
        gains = np.where((self._servo >= 0)[:, None], model.actuator_gainprm[self._servo], 0.0)
        self._gain, self._brake = gains[:, _GAIN], gains[:, _BRAKE]
        driven = self._gain > 0
        self._stall = np.where(driven, model.actuator_forcerange[self._servo, 1], 0.0)
        self._slope = self._stall * np.where(driven, gains[:, _CONSTANT], 0.0)
        self._lower, self._upper = model.actuator_ctrlrange[self._servo].T
        self._spring, self._rest = (
            model.jnt_stiffness[joints],
            model.qpos_spring[model.jnt_qposadr[joints]],
        )
        self._viscous = model.dof_damping[model.jnt_dofadr[joints]]
        self.stiffness, self.damping = self._gain + self._spring, self._brake + self._viscous

    def torques(self, control: Floats, angles: Floats, speeds: Floats) -> tuple[Floats, Floats]:
        """Return the servo torques and the total torques on the joints, (joints,) N m each.

        Args:
            control: commands to all servos, (servos,) rad.
            angles: angles of the joints, (joints,) rad.
            speeds: speeds of the joints, (joints,) rad/s.
        """
        commanded = np.clip(control[self._servo], self._lower, self._upper)
        wanted = self._gain * (commanded - angles) - self._brake * speeds
        # A DC motor's torque decreases from stall to 0 at its top speed; braking is limited, too.
        drop = self._slope * speeds
        torque = np.clip(wanted, -self._stall - drop, self._stall - drop)
        servo = np.clip(torque, -self._stall, self._stall)
        passive = self._spring * (angles - self._rest) + self._viscous * speeds
        return servo, servo - passive


# Indices in the gains of MuJoCo's dcmotor.
_CONSTANT, _GAIN, _BRAKE = 1, 4, 6
