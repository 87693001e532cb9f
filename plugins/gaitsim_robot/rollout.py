"""Simulate populations of a robot, record them frame by frame, and compute their motion."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion
from gaitsim.legged import STRIDE_FREQUENCY, commands_at
from gaitsim.portable import arcsin, arctan2, norm
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.simulation import FRAME_RATE, TIPPED, Simulation

ROUNDING = 1e-9  # steps, tolerance for rounding errors of whole steps


def delayed_commands(simulation: Simulation, commands: Floats, first: int, last: int) -> Floats:
    """Return the commanded angles of all servos in each physics step.

    Servos hold the standing pose until the first command arrives.

    Args:
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
        first: frame at the start of the steps.
        last: frame at the end of the steps.

    Returns:
        The angles, (population, (last − first) · steps + 1, servos) rad.
    """
    late = math.ceil(simulation.latency / simulation.model.opt.timestep - ROUNDING)
    steps = np.arange(first * simulation.steps, last * simulation.steps + 1) - late
    commanded = np.tile(simulation.rest, (len(commands), len(steps), 1))
    arrived = commanded[:, np.count_nonzero(steps < 0) :]
    moments = steps[steps >= 0] / simulation.steps
    angles = commands_at(commands, moments, FRAME_RATE / simulation.command_rate)
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
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad, each held
            for one frame.
    """
    import mujoco
    from mujoco import rollout

    model = simulation.model
    population, frames = commands.shape[:2]
    record = empty_record(simulation, population, frames)
    data = mujoco.MjData(model)
    state = np.tile(simulation.start, (population, 1))
    active = np.arange(population)
    for first, last, push in segments(simulation, frames):
        state[:, 1 + model.nq : 4 + model.nq] += push
        control = delayed_commands(simulation, commands, first, last)
        states, sensors = rollout.rollout(model, data, state, control)
        upright = record_segment(simulation, record, active, first, last, state, states, sensors)
        active, state = active[upright], np.ascontiguousarray(states[upright, -2])
        if not len(active):
            break
        if not upright.all():
            commands = commands[upright]
    return record


def segments(simulation: Simulation, frames: int) -> Iterator[tuple[int, int, Floats]]:
    """Yield the first and last frame of each segment, and the push before it, (3,) m/s."""
    pushed, push = simulation.push(frames)
    bounds = {*range(0, frames - 1, SEGMENT), frames - 1} | ({pushed} if push.any() else set())
    for first, last in pairwise(sorted(bounds)):
        yield first, last, push if first == pushed else np.zeros(3)


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
) -> NDArray[np.bool_]:
    """Record the frames `first` to `last` of robots.

    Args:
        simulation: simulation of one robot.
        record: record to update.
        active: indices of the robots.
        first: frame at the start of the segment.
        last: frame at the end of the segment.
        before: states at the start of the segment, (active, states).
        states: states after each step and after one more step, (active, steps, states).
        sensors: sensor values at the start of each of these steps, (active, steps, sensors).

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
    low = simulation.above(at_frames[..., 1:4]) < LOW * simulation.start[3]
    belly = sensors[:, ::steps, simulation.belly] > 0
    expected = before[:, :1] + np.arange(count + 1) * steps * step
    speed = norm(at_frames[..., 1 + nq : 4 + nq])
    # MuJoCo resets a robot, including its time, when its state is not finite.
    diverged = ~((np.abs(at_frames[..., 0] - expected) < step / 2) & (speed < FASTEST))
    down = (upward < TIPPED) | low | belly | diverged
    fallen = down.any(axis=1)
    for row in np.flatnonzero(fallen):
        individual, frame = active[row], first + int(np.argmax(down[row]))
        if diverged[row, frame - first]:
            record.failures[int(individual)] = (
                f"the simulation became unstable after {frame / FRAME_RATE:g} s; a shorter "
                "organism.dt or a lower organism.stiffness may help"
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
        simulation: simulation of one robot.
        commands: commands to the servos of the legs, (population, frames, joints) rad.
        engine: function that simulates the robots.
        frequency: stride frequency of the commands, (population,) Hz; None if unknown.
    """
    record = engine(simulation, commands)
    held = commands.copy()
    for individual in np.flatnonzero(record.lasted < commands.shape[1]):
        lasted = record.lasted[individual]
        held[individual, lasted:] = held[individual, max(lasted - 1, 0)]
    qpos, qvel = record.qpos, record.qvel
    torso = qpos[..., :3] - np.array([*simulation.start[1:3], 0.0])
    record.load[:, 0] = record.load[:, 1]  # the robot is standing before the start
    stance = record.load[..., 2] > 0
    weight = simulation.anatomy.mass * float(norm(simulation.model.opt.gravity))
    return Motion(
        FRAME_RATE,
        {
            "joint_angles": held,
            "joint_positions": qpos[..., simulation.qpos],
            "joint_velocities": qvel[..., simulation.dof],
            "torque": record.torque,
            "stall_torque": np.tile(simulation.stall_torque, (len(commands), 1)),
            "rms_torque": _rms_torque(record),
            "continuous_torque": np.tile(_continuous_torque(simulation), (len(commands), 1)),
            "torso": torso,
            "torso_velocity": qvel[..., :3],
            "orientation": orientation(simulation.turn(qpos[..., 3:7])),
            "height": simulation.above(qpos),
            "foot_positions": record.feet - np.array([*simulation.start[1:3], 0.0]),
            "stance": stance,
            "load": record.load,
            "slip": _slip(record, stance),
            "energy": record.work,
            STRIDE_FREQUENCY: np.zeros(len(commands)) if frequency is None else frequency,
            "lasted": np.maximum(record.lasted - 1, 0) / FRAME_RATE,
            "weight": np.full(len(commands), weight),
            "length": np.full(len(commands), simulation.anatomy.length),
            "configuration": qpos,
        },
        failures=record.failures,
    )


def _rms_torque(record: Record) -> Floats:
    """Return the root mean square torque until the fall, (population, joints) N m."""
    intervals = np.maximum(record.lasted - 1, 1)
    found: Floats = np.sqrt(record.square.sum(axis=1) / intervals[:, None])
    return found


def _continuous_torque(simulation: Simulation) -> Floats:
    """Return the torque that servos can deliver continuously, (joints,) N m; 0 if unknown."""
    servos = [simulation.servos[name] for name in simulation.anatomy.joints]
    return np.array([servo.continuous * servo.stall_torque for servo in servos])


def _slip(record: Record, stance: NDArray[np.bool_]) -> Floats:
    """Return the mean slide of stance feet since the previous frame, (population, frames) m."""
    slid = np.where(stance, record.slide, 0.0).sum(axis=2)
    slip: Floats = slid / np.maximum(stance.sum(axis=2), 1)
    return slip


def orientation(turn: Floats) -> Floats:
    """Return roll, pitch and yaw relative to the standing pose, (population, frames, 3) rad.

    Positive roll is to the right, positive pitch nose down, and positive yaw to the left. Yaw is
    continuous over whole turns.
    """
    w, x, y, z = np.moveaxis(turn, -1, 0)
    roll = arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.unwrap(arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), axis=1)
    return np.stack([roll, pitch, yaw], axis=-1)
