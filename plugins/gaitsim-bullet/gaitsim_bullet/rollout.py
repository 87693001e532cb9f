"""Simulate populations of robots in PyBullet, and record them as in MuJoCo."""

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim_bullet.body import BulletBody
from gaitsim_bullet.client import open_client
from gaitsim_bullet.ground import BASE
from gaitsim_robot import rollout
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.drives import Pushes
from gaitsim_robot.feeling import Pilot
from gaitsim_robot.rollout import (
    Feelings,
    Mover,
    Record,
    delayed_commands,
    empty_record,
    record_segment,
    segments,
)
from gaitsim_robot.servos import BRAKE, CONSTANT, GAIN
from gaitsim_robot.simulation import Simulation


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
        self._gain, self._brake = gains[:, GAIN], gains[:, BRAKE]
        driven = self._gain > 0
        self._stall = np.where(driven, model.actuator_forcerange[self._servo, 1], 0.0)
        self._slope = self._stall * np.where(driven, gains[:, CONSTANT], 0.0)
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


LONGEST_STEP = 0.002  # s
SHARE = 0.5  # longest step of explicit integration, as a share of the servos' time constants


def roll_out(simulation: Simulation, commands: Floats) -> Record:
    """Simulate robots independently, starting from standing.

    Args:
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
    """
    population, frames = commands.shape[:2]
    record = empty_record(simulation, population, frames)
    substeps = count_substeps(simulation)
    for individual in range(population):
        with open_client(simulation.model.opt.timestep / substeps) as client:
            walk = _Walk(BulletBody(client, simulation), substeps)
            before = simulation.start
            for first, last, push in segments(simulation, frames):
                if push.any():
                    walk.body.push(push)
                states, sensors = walk.advance(
                    delayed_commands(simulation, commands[[individual]], first, last)[0]
                )
                upright = record_segment(
                    simulation,
                    record,
                    np.array([individual]),
                    first,
                    last,
                    before[None],
                    states[None],
                    sensors[None],
                )
                if not upright[0]:
                    break
                before = states[-2]
    return record


class BulletMover(Mover):
    """A robot in PyBullet that moves frame by frame."""

    def __init__(self, simulation: Simulation, walk: "_Walk") -> None:
        self._walk = walk
        self.state = simulation.start[None].copy()

    def push(self, change: Floats) -> None:
        """Change the velocity of the trunk, (3,) m/s."""
        self._walk.body.push(change)

    def move(self, control: Floats) -> tuple[Floats, Floats]:
        """Simulate a frame; see `Mover.move`."""
        states, sensors = self._walk.advance(np.concatenate([control[0], control[0, -1:]]))
        self.state = states[None, -2].copy()
        self._sensors = sensors[None, -1:]
        return states[None, :-1], sensors[None, :-1]

    def sense(self, control: Floats) -> Floats:
        """Return the sensor values in the present state, (1, 1, sensors)."""
        return self._sensors

    def select(self, individuals: NDArray[np.bool_]) -> None:
        """Keep the robot."""


def feel_out(
    simulation: Simulation, pilot: Pilot, target: Floats, pushes: Pushes
) -> tuple[Record, Feelings]:
    """Simulate robots that feel, one after another; see `gaitsim_robot.rollout.feel_out`."""
    population = len(target)
    substeps = count_substeps(simulation)
    found = []
    for individual in range(population):
        own, rows = copy.copy(pilot), np.array([individual])
        own.select(rows)
        with open_client(simulation.model.opt.timestep / substeps) as client:
            mover = BulletMover(simulation, _Walk(BulletBody(client, simulation), substeps))
            found.append(rollout.feel_out(simulation, own, target[rows], pushes, mover))
    records, feelings = zip(*found, strict=True)
    failures = {n: one.failures[0] for n, one in enumerate(records) if one.failures}
    return Record(**_joined(records), failures=failures), Feelings(**_joined(feelings))


def _joined(parts: Sequence[Record] | Sequence[Feelings]) -> dict[str, Any]:
    """Return the arrays of several populations as those of one, by name."""
    names = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    return {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}


def count_substeps(simulation: Simulation) -> int:
    """Return the number of Bullet's steps per step of MuJoCo.

    Bullet integrates the springs and dampers of servos explicitly. A step is therefore at most
    `LONGEST_STEP`, and at most `SHARE` of the servos' shortest time constant when standing.
    """
    import mujoco

    model = simulation.model
    data = mujoco.MjData(model)
    data.qpos[:] = simulation.start[1 : 1 + model.nq]
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    drives = Drives(model, np.arange(1, model.njnt))
    rates = []
    for constants in (drives.damping, drives.stiffness):
        full = np.zeros(model.nv)
        full[model.jnt_dofadr[1:]] = constants
        rates.append(np.abs(np.linalg.eigvals(np.linalg.solve(inertia, np.diag(full)))).max())
    fastest = float(max(rates[0], math.sqrt(rates[1]), SHARE / LONGEST_STEP))
    return math.ceil(float(model.opt.timestep) * fastest / SHARE - 1e-9)


class _Walk:
    """A walking robot, with states and sensors in MuJoCo's order."""

    def __init__(self, body: BulletBody, substeps: int) -> None:
        import mujoco

        self.body, self.simulation, self.substeps = body, body.simulation, substeps
        self.model = self.simulation.model
        self.drives = Drives(self.model, body.joints)
        self.data: Any = mujoco.MjData(self.model)
        self.steps = 0
        bodies = [link.body for link in body.links]
        feet = [self.model.body(leg.foot).id for leg in self.simulation.anatomy.legs]
        # A lost foot has no link.
        self.foot_index = {bodies.index(foot): n for n, foot in enumerate(feet) if foot in bodies}
        joints = [self.model.joint(name).id for name in self.simulation.anatomy.joints]
        places = {int(joint): n for n, joint in enumerate(body.joints)}
        self.known = np.array([n for n, joint in enumerate(joints) if joint in places], np.intp)
        self.driven = np.array([places[joint] for joint in joints if joint in places], np.intp)

    def advance(self, control: Floats) -> tuple[Floats, Floats]:
        """Simulate some steps; return the states after them, and the sensors at their starts.

        Args:
            control: commands to all servos in each of MuJoCo's steps, (steps + 1, servos) rad; the
                last step is not simulated.

        Returns:
            The states, (steps + 1, states), and the sensors, (steps + 1, sensors). The last state
            repeats the one before.
        """
        simulation, model = self.simulation, self.model
        count = len(control) - 1
        states = np.full((count + 1, len(simulation.start)), np.nan)
        sensors = np.zeros((count + 1, model.nsensordata))
        self._read_positions(sensors[0])
        for step in range(count):
            for _ in range(self.substeps):
                self._step(control[step], sensors[step])
            self.steps += 1
            state = np.concatenate(self.body.state())
            if not np.isfinite(state).all():
                break
            states[step, 0] = self.steps * model.opt.timestep
            states[step, 1 : 1 + len(state)] = state
            if (step + 1) % simulation.steps == 0:
                self._read_positions(sensors[step + 1])
        states[-1] = states[-2]
        return states, sensors

    def _step(self, control: Floats, sensors: Floats) -> None:
        """Simulate one step, and add its share of torques and contacts to the sensors."""
        body, simulation = self.body, self.simulation
        servo, torque = self.drives.torques(control, *body.angles())
        contacts = body.step(torque)
        sensors[simulation.torque[self.known]] += np.abs(servo[self.driven]) / self.substeps
        for link, foot in self.foot_index.items():
            if link not in contacts:
                continue
            contact = contacts[link]
            sensors[simulation.load[foot]] += np.divide(contact.force, self.substeps)
            sensors[simulation.slide[foot][1]] += math.hypot(*contact.slip) / self.substeps

    def _read_positions(self, sensors: Floats) -> None:
        """Write the positions of the feet and the trunk's contacts to the sensors."""
        import mujoco

        body, simulation = self.body, self.simulation
        self.data.qpos[:] = body.state()[0]
        mujoco.mj_kinematics(self.model, self.data)
        for foot, leg in enumerate(simulation.anatomy.legs):
            sensors[simulation.feet[foot]] = self.data.site(f"world: foot {leg.name}").xpos
        sensors[simulation.belly] = body.ground.touches(BASE)
