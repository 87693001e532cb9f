"""The body of a virtual robot: MuJoCo, with servos that are commanded and switched one by one."""

import copy
from collections import deque

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import product, rotated
from gaitsim_robot.simulation import Simulation

Floats = NDArray[np.float64]

LONGEST = 1.0  # s, longest time simulated at once; a longer gap counts as a pause
ROOM = 25.0  # °C
HEATING = 6.0  # K, warming of a servo at its continuous load
CONTINUOUS = 0.2  # share of the stall torque
HEAVY = 1e4  # times the mass of a trunk that hangs
WARMING = 300.0  # s, time constant of the temperature


class ServoRobot:
    """A robot in MuJoCo whose servos hold goals, and stand off at the start.

    Args:
        simulation: simulation of the robot, standing.
        hung: whether the robot hangs in the air by its trunk.

    Attributes:
        goal: goal of each servo as an angle of its joint, (joints,) rad.
        on: whether each servo has torque, (joints,).
        strength: share of each servo's torque, (joints,).
        temperature: temperature of each servo, (joints,) °C.
        seconds: simulated time, s.
    """

    def __init__(self, simulation: Simulation, *, hung: bool = False) -> None:
        import mujoco

        self._simulation, self._model = simulation, copy.copy(simulation.model)
        self._data = mujoco.MjData(self._model)
        state = mujoco.mjtState.mjSTATE_FULLPHYSICS
        mujoco.mj_setState(self._model, self._data, simulation.start, state)
        self._held: Floats | None = None  # pose of the trunk
        if hung:
            self._hang()
        self._torque = self._model.actuator_forcerange[simulation.ctrl].copy()
        joints = len(simulation.ctrl)
        self.goal = self.angles
        self.on = np.zeros(joints, dtype=np.bool_)
        self.strength = np.ones(joints)
        self.temperature = np.full(joints, ROOM)
        self.seconds = 0.0
        self._late: deque[tuple[float, Floats]] = deque()
        self._data.ctrl[:] = simulation.rest

    def _hang(self) -> None:
        """Hold the trunk in the air: it becomes so heavy that legs do not move it."""
        model, data, trunk = self._model, self._data, 1
        for of_trunk in (model.body_mass, model.body_inertia):
            of_trunk[trunk] *= HEAVY
        data.qpos[2] += 2 * self._simulation.height
        data.xfrc_applied[trunk, :3] = -model.body_mass[trunk] * model.opt.gravity
        self._held = data.qpos[:7].copy()

    @property
    def angles(self) -> Floats:
        """Angle of each joint as its servo measures it, without the error of the horn, rad."""
        simulation = self._simulation
        return np.asarray(self._data.qpos[simulation.qpos] - simulation.offset)

    @property
    def load(self) -> Floats:
        """Torque of each servo as a share of its stall torque, (joints,)."""
        simulation = self._simulation
        return np.asarray(self._data.actuator_force[simulation.ctrl] / self._torque[:, 1])

    @property
    def orientation(self) -> Floats:
        """Rotation of the trunk relative to the standing pose, a quaternion, (4,)."""
        return self._simulation.turn(np.array(self._data.qpos[3:7]))

    @property
    def rates(self) -> Floats:
        """Angular velocity about the trunk's axes, (3,) rad/s."""
        spin = np.array(self._data.qvel[3:6])
        return rotated(self._simulation.anatomy.stance[3:7], spin)

    @property
    def place(self) -> Floats:
        """Position of the trunk, (3,) m."""
        return np.array(self._data.qpos[:3])

    def turn_over(self) -> None:
        """Lay the robot on its side."""
        half = np.sqrt(0.5)
        self._data.qpos[3:7] = product(np.array([half, half, 0.0, 0.0]), self._data.qpos[3:7])
        self._data.qpos[2] *= 1.5

    def advance(self, seconds: float) -> None:
        """Simulate to a time; of a gap of more than a second, only the last second."""
        self.seconds = max(self.seconds, seconds - LONGEST)
        step = self._model.opt.timestep
        steps = int((seconds - self.seconds) / step + 1e-6)
        if steps < 1:
            return
        simulation = self._simulation
        # Commands take effect with the latency of the servos.
        self._late.append((self.seconds + simulation.latency, self.goal.copy()))
        force = np.where(self.on, self.strength, 0.0)[:, None] * self._torque
        self._model.actuator_forcerange[simulation.ctrl] = force
        before = np.square(self.load)
        if self._held is not None:
            self._data.qpos[:7], self._data.qvel[:6] = self._held, 0.0
        self._move(steps)
        self.seconds += steps * step
        heat = HEATING / CONTINUOUS**2 * (before + np.square(self.load)) / 2
        share = min(steps * step / WARMING, 1.0)
        self.temperature += share * (ROOM + heat - self.temperature)

    def _move(self, steps: int) -> None:
        import mujoco

        simulation, step, done = self._simulation, self._model.opt.timestep, 0
        lower, upper = self._model.actuator_ctrlrange[simulation.ctrl].T
        while done < steps:
            now = self.seconds + done * step
            while self._late and self._late[0][0] <= now + 1e-9:
                goal = self._late.popleft()[1] + simulation.offset
                self._data.ctrl[simulation.ctrl] = np.clip(goal, lower, upper)
            count = steps - done
            if self._late:
                count = min(count, max(int((self._late[0][0] - now) / step + 1 - 1e-6), 1))
            mujoco.mj_step(self._model, self._data, count)
            done += count

    def hold(self) -> None:
        """Let all servos hold their present angles."""
        self.goal = self.angles
