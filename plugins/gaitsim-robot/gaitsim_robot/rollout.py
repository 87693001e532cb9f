"""Simulate populations of a robot, record them frame by frame, and compute their motion."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import COMMAND, Motion, product, rotated
from gaitsim.plugin.toolkit import STRIDE_FREQUENCY, arcsin, arctan2, commands_at, downward, norm
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.drives import Pushes
from gaitsim_robot.feeling import Pilot, Truth
from gaitsim_robot.simulation import FRAME_RATE, TIPPED, Simulation

TURN = 2 * math.pi
ROUNDING = 1e-9  # steps, tolerance for rounding errors of whole steps


def delayed_commands(
    simulation: Simulation, commands: Floats, first: int, last: int, origin: int = 0
) -> Floats:
    """Return the commanded angles of all servos in each physics step.

    Servos hold the standing pose until the first command arrives.

    Args:
        simulation: simulation of the robots.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
        first: frame at the start of the steps.
        last: frame at the end of the steps.
        origin: number of the first frame of `commands`.

    Returns:
        The angles, (population, (last − first) · steps + 1, servos) rad.
    """
    late = math.ceil(simulation.latency / simulation.model.opt.timestep - ROUNDING)
    steps = np.arange(first * simulation.steps, last * simulation.steps + 1) - late
    rest = np.array([body.rest for body in simulation.each])
    shape = len(commands), len(steps), rest.shape[-1]
    commanded = np.broadcast_to(rest[:, None], shape).copy()
    arrived = commanded[:, np.count_nonzero(steps < 0) :]
    moments = steps[steps >= 0] / simulation.steps
    angles = commands_at(commands, moments, FRAME_RATE / simulation.command_rate, origin)
    if simulation.offset.any():
        lower, upper = simulation.model.actuator_ctrlrange[simulation.ctrl].T
        angles = np.clip(angles + simulation.offset, lower, upper)
    arrived[..., simulation.ctrl] = angles
    return commanded


SEGMENT = 50
"""Number of frames simulated at once. Later segments omit robots that have fallen."""

LOW = 0.4  # share of the standing height; a robot with a lower trunk has fallen
FASTEST = 100.0  # m/s, speed of the trunk above which the simulation is unstable


@dataclass(eq=False)
class Record:
    """The record of a population.

    After a fall, positions and work stay constant, and all other quantities are 0.

    Attributes:
        qpos: positions, (population, frames, nq).
        qvel: velocities, (population, frames, nv).
        torque: mean magnitude of the torque since the previous frame, (population, frames, joints)
            N m.
        square: mean square of the torque since the previous frame, (population, frames, joints)
            N² m².
        load: mean force of the ground on each foot since the previous frame,
            (population, frames, feet, 3) N.
        slide: slide of each foot's strongest contact since the previous frame,
            (population, frames, feet) m.
        feet: positions of the feet, (population, frames, feet, 3) m.
        work: work of the servos since the start, (population, frames) J; braking counts as
            positive.
        lasted: number of frames before the fall, or of all frames, (population,).
        failures: reasons why the simulation of an individual failed, by index.
    """

    qpos: Floats
    qvel: Floats
    torque: Floats
    square: Floats
    load: Floats
    slide: Floats
    feet: Floats
    work: Floats
    lasted: NDArray[np.intp]
    failures: dict[int, str]


RollOut = Callable[[Simulation, Floats], Record]
"""Function that simulates robots in a physics engine, as `roll_out` does in MuJoCo."""


def roll_out(simulation: Simulation, commands: Floats) -> Record:
    """Simulate robots independently, starting from standing.

    Args:
        simulation: simulation of the robots.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
    """
    import mujoco
    from mujoco import rollout

    model = simulation.model
    population, frames = commands.shape[:2]
    record = empty_record(simulation, population, frames)
    data = mujoco.MjData(model)
    state = np.broadcast_to(simulation.starts, (population, len(simulation.start))).copy()
    active = np.arange(population)
    for first, last, push in segments(simulation, frames):
        state[:, 1 + model.nq : 4 + model.nq] += push
        control = delayed_commands(simulation, commands, first, last)
        states, sensors = rollout.rollout(simulation.models, data, state, control)
        upright = record_segment(simulation, record, active, first, last, state, states, sensors)
        active, state = active[upright], np.ascontiguousarray(states[upright, -2])
        if not len(active):
            break
        if not upright.all():
            commands, simulation = commands[upright], simulation.select(upright)
    return record


def segments(
    simulation: Simulation, frames: int, pushes: Pushes = MappingProxyType({})
) -> Iterator[tuple[int, int, Floats]]:
    """Yield the first and last frame of each segment, and the push before it, (3,) m/s."""
    pushed, push = simulation.push(frames)
    by_frame = dict(pushes)
    if push.any():
        by_frame[pushed] = by_frame.get(pushed, 0.0) + push
    whole = simulation.anatomy.crawls  # never falls
    bounds = {*range(0, frames - 1, frames if whole else SEGMENT), frames - 1}
    bounds |= {frame for frame in by_frame if frame < frames - 1}
    for first, last in pairwise(sorted(bounds)):
        yield first, last, by_frame.get(first, np.zeros(3))


@dataclass(eq=False)
class Feelings:
    """Commands, measurements and servo angles of a population that feels, frame by frame.

    Attributes:
        angles: commands to the servos of the legs, (population, frames, joints) rad.
        command: commands of the driver, smoothed, (population, frames, 4), as `COMMAND`.
        changed: commands with the changes of reflexes, (population, frames, 4).
        measured: measured roll, pitch and yaw, (population, frames, 3) rad.
        heading: direction that the commands ask for, (population, frames) rad.
    """

    angles: Floats
    command: Floats
    changed: Floats
    measured: Floats
    heading: Floats

    def channels(self) -> dict[str, Floats]:
        """Return the channels of a motion that only robots that feel have."""
        return {
            "command": self.command,
            "changed_command": self.changed,
            "measured_orientation": self.measured,
            "commanded_heading": self.heading,
        }

    def hold_last(self) -> None:
        """Hold the values of the last frame but one, as no command follows from the last frame."""
        for values in vars(self).values():
            values[:, -1] = values[:, -2]


class Mover:
    """Robots in MuJoCo that move frame by frame.

    Attributes:
        state: physics states, (active, states).
    """

    def __init__(self, simulation: Simulation, population: int) -> None:
        import mujoco

        self._simulation, self._model = simulation, simulation.model
        self._data = mujoco.MjData(self._model)
        self._warm = np.zeros((population, self._model.nv))
        shape = population, len(simulation.start)
        self.state = np.broadcast_to(simulation.starts, shape).copy()

    def push(self, change: Floats) -> None:
        """Change the velocity of the trunks, (3,) m/s."""
        self.state[:, 1 + self._model.nq : 4 + self._model.nq] += change

    def move(self, control: Floats) -> tuple[Floats, Floats]:
        """Simulate a frame.

        Args:
            control: commands to all servos in each step, (active, steps, servos) rad.

        Returns:
            The states after each step, (active, steps, states), and the sensor values at the start
            of each step, (active, steps, sensors).
        """
        from mujoco import rollout

        states, sensors = rollout.rollout(
            self._simulation.models,
            self._data,
            self.state,
            control,
            initial_warmstart=self._warm,
        )
        first = 1 + self._model.nq
        speeds = states[:, -2:, first : first + self._model.nv]
        # The solver starts from the last acceleration, as it does within a rollout.
        self._warm = (speeds[:, -1] - speeds[:, 0]) / self._model.opt.timestep
        self.state = np.ascontiguousarray(states[:, -1])
        return states, sensors

    def sense(self, control: Floats) -> Floats:
        """Return the sensor values in the present state, (active, 1, sensors)."""
        from mujoco import rollout

        found: Floats = rollout.rollout(self._simulation.models, self._data, self.state, control)[1]
        return found

    def select(self, individuals: NDArray[np.bool_]) -> None:
        """Keep some robots."""
        self._simulation = self._simulation.select(individuals)
        self.state = np.ascontiguousarray(self.state[individuals])
        self._warm = np.ascontiguousarray(self._warm[individuals])


def feel_out(
    simulation: Simulation, pilot: Pilot, target: Floats, pushes: Pushes, mover: Mover | None = None
) -> tuple[Record, Feelings]:
    """Simulate robots that feel, in lock step, starting from standing.

    Args:
        simulation: simulation of the robots.
        pilot: controllers of the population.
        target: commands of the driver in each frame, (population, frames, 4), as `COMMAND`.
        pushes: changes of velocity by frame, besides that of the world, (3,) m/s.
        mover: robots standing in another physics engine; None for MuJoCo.
    """
    population, frames = target.shape[:2]
    record = empty_record(simulation, population, frames)
    walk = LockStep(simulation, pilot, target, mover or Mover(simulation, population))
    active = np.arange(population)
    for first, last, push in segments(simulation, frames, pushes):
        if push.any():
            walk.mover.push(push)
        before = walk.mover.state.copy()
        states, sensors = walk.advance(active, first, last)
        upright = record_segment(
            simulation, record, active, first, last, before, states, sensors, walk.failures
        )
        active = active[upright]
        if not len(active):
            break
        if not upright.all():
            walk.select(upright)
            simulation = simulation.select(upright)
    walk.feelings.hold_last()
    return record, walk.feelings


def upright_turn(down: Floats) -> Floats:
    """Return the smallest rotation that turns a direction, (3,), to −z, as a quaternion, (4,)."""
    x, y, z = down
    found = np.array([1.0 - z, -y, x, 0.0])
    return np.asarray(found / norm(found))


class LockStep:
    """Robots that walk in lock step: in each frame, all of them feel, and then move.

    Attributes:
        mover: the robots.
        feelings: their commands, measurements and servo angles.
        failures: reasons by individual, whose reflexes gave invalid inputs.
    """

    def __init__(self, simulation: Simulation, pilot: Pilot, target: Floats, mover: Mover) -> None:
        population, frames = target.shape[:2]
        self._simulation, self._pilot, self._target = simulation, pilot, target
        self.mover = mover
        self._load = np.full((population, len(simulation.load)), 1 / len(simulation.load))
        # An IMU feels gravity, which slopes tilt.
        self._level = upright_turn(downward(simulation.world))
        self._first = tilt_and_yaw(self._level)[2]
        self._yaw = np.full(population, self._first)
        # Number of frames from which a delayed command may come.
        self._memory = math.ceil(simulation.latency * FRAME_RATE)
        self._memory += math.ceil(FRAME_RATE / simulation.command_rate) + 1
        weight = simulation.mass * float(norm(simulation.model.opt.gravity))
        self._weight = np.where(weight > 0, weight, 1.0)[:, None]
        self.failures: dict[int, str] = {}
        self.feelings = Feelings(
            np.broadcast_to(
                pilot.rhythm.standing.reshape(-1, 1, len(simulation.qpos)),
                (population, frames, len(simulation.qpos)),
            ).copy(),
            np.zeros((population, frames, len(COMMAND))),
            np.zeros((population, frames, len(COMMAND))),
            np.zeros((population, frames, 3)),
            np.zeros((population, frames)),
        )

    def advance(self, active: NDArray[np.intp], first: int, last: int) -> tuple[Floats, Floats]:
        """Advance from frame `first` to `last`; return states and sensors for `record_segment`."""
        simulation, pilot = self._simulation, self._pilot
        states, sensors = [], []
        for frame in range(first, last):
            angles, origin = self._feel(active, frame)
            control = delayed_commands(simulation, angles, frame, frame + 1, origin)[:, :-1]
            after, found = self.mover.move(control)
            # A robot whose reflex fails ends as one whose simulation is unstable.
            after[[*pilot.failures], :, 0] = np.nan
            for row, reason in pilot.failures.items():
                self.failures.setdefault(int(active[row]), reason)
            states.append(after)
            sensors.append(found)
            self._load = found[:, :, simulation.load[:, 2]].mean(axis=1) / self._weight
        states.append(self.mover.state[:, None])
        sensors.append(self.mover.sense(control[:, -1:]))
        return np.concatenate(states, axis=1), np.concatenate(sensors, axis=1)

    def _feel(self, active: NDArray[np.intp], frame: int) -> tuple[Floats, int]:
        """Let robots feel; return their latest commands, and the frame of the first of these."""
        simulation, pilot, felt = self._simulation, self._pilot, self.feelings
        nq, state = simulation.model.nq, self.mover.state
        qpos, spin = state[:, 1 : 1 + nq], state[:, 4 + nq : 7 + nq]
        turned = tilt_and_yaw(product(self._level, simulation.turn(qpos[:, 3:7])))
        turned[:, 2] -= TURN * np.rint((turned[:, 2] - self._yaw) / TURN)
        self._yaw = turned[:, 2].copy()
        turned[:, 2] -= self._first
        truth = Truth(
            turned,
            rotated(simulation.anatomy.stance[3:7], spin),
            self._load,
            qpos[:, simulation.qpos],
        )
        felt.angles[active, frame] = pilot.step(frame, self._target[:, frame], truth)
        felt.command[active, frame] = pilot.command
        felt.changed[active, frame] = pilot.inputs.command
        felt.measured[active, frame] = pilot.seen.orientation
        felt.heading[active, frame] = pilot.heading
        origin = max(0, frame - self._memory)
        return felt.angles[active, origin : frame + 1], origin

    def select(self, upright: NDArray[np.bool_]) -> None:
        """Keep some of the active robots."""
        self._pilot.select(np.flatnonzero(upright))
        self.mover.select(upright)
        self._simulation = self._simulation.select(upright)
        if len(self._weight) > 1:
            self._weight = self._weight[upright]
        self._target, self._load = self._target[upright], self._load[upright]
        self._yaw = self._yaw[upright]


def empty_record(simulation: Simulation, population: int, frames: int) -> Record:
    """Return an empty record."""
    model, joints, feet = simulation.model, len(simulation.dof), len(simulation.anatomy.legs)
    return Record(
        np.zeros((population, frames, model.nq)),
        np.zeros((population, frames, model.nv)),
        np.zeros((population, frames, joints)),
        np.zeros((population, frames, joints)),
        np.zeros((population, frames, feet, 3)),
        np.zeros((population, frames, feet)),
        np.zeros((population, frames, feet, 3)),
        np.zeros((population, frames)),
        np.full(population, frames),
        {},
    )


def record_segment(
    simulation: Simulation,
    record: Record,
    active: NDArray[np.intp],
    first: int,
    last: int,
    before: Floats,
    states: Floats,
    sensors: Floats,
    reasons: Mapping[int, str] = MappingProxyType({}),
) -> NDArray[np.bool_]:
    """Record the frames `first` to `last` of robots.

    Args:
        simulation: simulation of the robots.
        record: record to update.
        active: indices of the robots.
        first: frame at the start of the segment.
        last: frame at the end of the segment.
        before: states at the start of the segment, (active, states).
        states: states after each step and after one more step, (active, steps, states).
        sensors: sensor values at the start of each of these steps, (active, steps, sensors).
        reasons: reasons why individuals failed, unless their simulation became unstable.

    Returns:
        Whether each robot is still upright, (active,).
    """
    model, steps = simulation.model, simulation.steps
    count, nq, nv = last - first, model.nq, model.nv
    at_frames = np.concatenate([before[:, None], states[:, steps - 1 : -1 : steps]], axis=1)
    span = slice(first, last + 1)
    record.qpos[active, span] = at_frames[..., 1 : 1 + nq]
    record.qvel[active, span] = at_frames[..., 1 + nq : 1 + nq + nv]
    record.feet[active, span] = sensors[:, ::steps, simulation.feet]
    after = slice(first + 1, last + 1)

    def during(indices: NDArray[np.intp]) -> Floats:
        # Select the columns first, as the reshape copies its input.
        taken = sensors[:, :-1, indices.ravel()]
        return taken.reshape(len(active), count, steps, *indices.shape)

    torque = np.abs(during(simulation.torque))
    record.torque[active, after] = torque.mean(axis=2)
    record.square[active, after] = np.square(torque).mean(axis=2)
    record.load[active, after] = during(simulation.load).mean(axis=2)
    slide = during(simulation.slide[:, 1:])
    step = model.opt.timestep
    record.slide[active, after] = norm(slide[..., :2]).sum(axis=2) * step
    column = 1 + nq + simulation.dof
    speeds = np.concatenate([before[:, None, column], states[:, :-2, column]], axis=1)
    power = (torque * np.abs(speeds.reshape(torque.shape))).sum(axis=(2, 3)) * step
    record.work[active, after] = record.work[active, first, None] + np.cumsum(power, axis=1)

    turn = simulation.turn(at_frames[..., 4:8])
    upward = 1 - 2 * (np.square(turn[..., 1]) + np.square(turn[..., 2]))
    low = simulation.above(at_frames[..., 1:4]) < LOW * simulation.starts[:, 3:4]
    belly = sensors[:, ::steps, simulation.belly] > 0
    expected = before[:, :1] + np.arange(count + 1) * steps * step
    speed = norm(at_frames[..., 1 + nq : 4 + nq])
    # MuJoCo resets a robot, including its time, when its state is not finite.
    diverged = ~((np.abs(at_frames[..., 0] - expected) < step / 2) & (speed < FASTEST))
    fell = (upward < TIPPED) | low | belly
    down = diverged if simulation.anatomy.crawls else diverged | fell
    fallen = down.any(axis=1)
    for row in np.flatnonzero(fallen):
        individual, frame = active[row], first + int(np.argmax(down[row]))
        if diverged[row, frame - first]:
            unstable = "the simulation became unstable"
            remedy = "; a shorter organism.dt or a lower organism.stiffness may help"
            reason = reasons.get(int(individual))
            record.failures[int(individual)] = (
                f"{reason or unstable} after {frame / FRAME_RATE:g} s{'' if reason else remedy}"
            )
        record.lasted[individual] = frame
        _freeze(record, individual, frame)
    upright: NDArray[np.bool_] = ~fallen
    return upright


def _freeze(record: Record, individual: int, frame: int) -> None:
    """Hold the positions and work from before a fall, and set the other quantities to 0."""
    still = max(frame - 1, 0)
    for kept in (record.qpos, record.feet, record.work):
        kept[individual, frame:] = kept[individual, still]
    for ended in (record.qvel, record.torque, record.square, record.load, record.slide):
        ended[individual, frame:] = 0.0


def walk(
    simulation: Simulation,
    commands: Floats,
    engine: RollOut = roll_out,
    frequency: Floats | None = None,
) -> Motion:
    """Return the motion of robots whose servos follow commands.

    Args:
        simulation: simulation of the robots.
        commands: commands to the servos of the legs, (population, frames, joints) rad.
        engine: function that simulates the robots.
        frequency: stride frequency of the commands, (population,) Hz; None if unknown.
    """
    return motion_of(simulation, engine(simulation, commands), commands, frequency)


def motion_of(
    simulation: Simulation,
    record: Record,
    commands: Floats,
    frequency: Floats | None = None,
    feelings: Feelings | None = None,
) -> Motion:
    """Return the motion of robots from their record; arguments as in `walk`.

    Args:
        simulation: simulation of the robots.
        record: record of the robots.
        commands: commands to the servos of the legs, (population, frames, joints) rad.
        frequency: stride frequency of the commands, (population,) Hz; None if unknown.
        feelings: commands and measurements of robots that feel; None for other robots.
    """
    felt = {} if feelings is None else feelings.channels()
    held = commands.copy()
    for individual in np.flatnonzero(record.lasted < commands.shape[1]):
        lasted = record.lasted[individual]
        held[individual, lasted:] = held[individual, max(lasted - 1, 0)]
    qpos, qvel = record.qpos, record.qvel
    starts = simulation.starts[:, None, 1:4] * [1.0, 1.0, 0.0]
    torso = qpos[..., :3] - starts
    record.load[:, 0] = record.load[:, 1]  # the robot is standing before the start
    stance = record.load[..., 2] > 0
    weight = simulation.mass * float(norm(simulation.model.opt.gravity))
    length = np.array([body.anatomy.length for body in simulation.each])

    def spread(values: Floats) -> Floats:
        return np.broadcast_to(values, (len(commands), *values.shape[1:])).copy()

    return Motion(
        FRAME_RATE,
        {
            "joint_angles": held,
            "joint_positions": qpos[..., simulation.qpos],
            "joint_velocities": qvel[..., simulation.dof],
            "torque": record.torque,
            "stall_torque": spread(simulation.stall_torque),
            "rms_torque": _rms_torque(record),
            "continuous_torque": spread(simulation.continuous_torque),
            "torso": torso,
            "torso_velocity": qvel[..., :3],
            "orientation": orientation(simulation.turn(qpos[..., 3:7])),
            "height": simulation.above(qpos),
            "foot_positions": record.feet - starts[:, None],
            "stance": stance,
            "load": record.load,
            "slip": _slip(record, stance),
            "energy": record.work,
            STRIDE_FREQUENCY: np.zeros(len(commands)) if frequency is None else frequency,
            "lasted": np.maximum(record.lasted - 1, 0) / FRAME_RATE,
            "weight": spread(weight),
            "length": spread(length),
            "configuration": qpos,
            **felt,
        },
        failures=record.failures,
    )


def _rms_torque(record: Record) -> Floats:
    """Return the root mean square torque until the fall, (population, joints) N m."""
    intervals = np.maximum(record.lasted - 1, 1)
    found: Floats = np.sqrt(record.square.sum(axis=1) / intervals[:, None])
    return found


def _slip(record: Record, stance: NDArray[np.bool_]) -> Floats:
    """Return the mean slide of stance feet since the previous frame, (population, frames) m."""
    slid = np.where(stance, record.slide, 0.0).sum(axis=2)
    slip: Floats = slid / np.maximum(stance.sum(axis=2), 1)
    return slip


def orientation(turn: Floats) -> Floats:
    """Return roll, pitch and yaw relative to the standing pose, (population, frames, 3) rad.

    Yaw is continuous over whole turns.
    """
    found = tilt_and_yaw(turn)
    found[..., 2] = np.unwrap(found[..., 2], axis=1)
    return found


def tilt_and_yaw(turn: Floats) -> Floats:
    """Return roll, pitch and yaw of rotations of the trunk, (…, 4), in (…, 3) rad.

    Positive roll is to the right, positive pitch nose down, and positive yaw to the left.
    """
    w, x, y, z = turn[..., 0], turn[..., 1], turn[..., 2], turn[..., 3]
    roll = arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=-1)
