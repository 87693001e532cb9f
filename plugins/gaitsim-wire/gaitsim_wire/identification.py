"""Fit the simulation of a robot to recordings of its drives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, conjugate, product, rotated, turn_about
from gaitsim.plugin.gait import read_bounded, read_gait, read_npz
from gaitsim_robot.conditions import apply_world, lowest_points
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import orientation
from gaitsim_robot.simulation import Simulation
from gaitsim_wire.driving import RATE

Floats = NDArray[np.float64]

SHORTEST = 10.0  # s of a recording, besides rising and lying down
LARGEST = 64 * 2**20  # bytes of a recording, packed and unpacked
LOST = 0.5  # share of missing values above which a quantity was not measured
LONGEST = 1.0  # s between frames
MOST = 100.0  # rad, rad/s; larger values are impossible
FALLEN = 0.8  # rad; a robot that tilted further was not walking
KEPT = ("mass", "servo_speed", "grip")  # conditions of the world that are not fitted

WARM = 25  # frames simulated before each window, in which unknown forces between feet fade
WINDOW = 150  # frames; contacts make longer simulations chaotic
BLOCK = 10  # frames that are averaged, since the moment of each contact is uncertain
MEASURED = (("measured", 2e-4), ("load", 5e-4), ("orientation", 5e-5), ("rates", 1e-3))
"""Measured quantities that are compared, with the smallest deviation worth fitting."""
LEAST = 0.02  # smallest friction, and smallest factor of torque and stiffness, that is simulated
DISTANCE = 0.02  # smallest relative deviation of a typed distance worth fitting


@dataclass(frozen=True)
class Parameter:
    """A parameter of the simulation that is fitted.

    Attributes:
        step: change in the first designs.
        spread: standard deviation of its value around the start, before anything is measured.
        low: smallest value.
        high: largest value.
        floor: standard error that remains however long a recording is: the deviation of fits of
            virtual robots from the planted values, which resampling does not show.
    """

    step: float
    spread: float
    low: float
    high: float
    floor: float


WORLD = {
    "friction": Parameter(0.07, 0.4, 0.05, 3.0, 0.003),
    "servo_torque": Parameter(0.07, 0.3, 0.2, 3.0, 0.001),
    "servo_stiffness": Parameter(0.07, 0.5, 0.2, 5.0, 0.001),
    "latency": Parameter(0.005, 0.03, 0.0, 0.2, 0.0005),
}
"""Conditions of the world that are fitted; the latency in s."""
HORN = Parameter(1.5, 3.0, -20.0, 20.0, 0.25)
"""The error of a horn, in °."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """A drive of a robot, frame by frame; gaps are interpolated.

    Attributes:
        path: path of the file.
        span: frames in which the robot walks, besides the first ones.
        sent: times at which the commands were sent, (frames,) s.
        read: times at which the servos were read, (frames,) s.
        ended: times at which reading ended, with the IMU, (frames,) s.
        commanded: commanded angles, (frames, joints) rad.
        values: measured quantities by name, as in `driving.COLUMNS`, without those that the robot
            does not measure; yaw is continuous.
        distance: distance that the robot walked, m; NaN if unknown.
    """

    path: Path
    span: slice
    sent: Floats
    read: Floats
    ended: Floats
    commanded: Floats
    values: Mapping[str, Floats]
    distance: float


def read_recording(path: Path, joints: Sequence[str], distance: float = np.nan) -> Recorded:
    """Read the telemetry of a drive.

    Args:
        path: path of the gait file that `gaitsim drive` wrote.
        joints: names of the robot's joints.
        distance: distance that the robot walked, m.

    Raises:
        GaitsimError: the file is not a recording of this robot from which it could be identified.
    """
    gait = read_gait(path)
    width = gait.in_order(joints).shape[1]
    columns = (
        read_npz(read_bounded(path, LARGEST), LARGEST) if path.suffix.lower() == ".npz" else {}
    )
    frames = np.size(columns.get("seconds", 0))
    shapes = {
        "seconds": (frames,), "round_trip": (frames,), "driving": (frames,),
        "commanded": (frames, width), "measured": (frames, width), "load": (frames, width),
        "orientation": (frames, 3), "rates": (frames, 3),
    }  # fmt: skip
    for name, shape in shapes.items():
        column = np.asarray(columns.get(name))
        if column.dtype.kind not in "fb" or column.shape != shape:
            raise _unusable(path, f"is not a recording of a drive: it has no {name}, {shape}")
    found = {name: columns[name].astype(np.float64) for name in shapes}
    driven = np.flatnonzero(found.pop("driving"))
    seconds, taken = found.pop("seconds"), found.pop("round_trip")
    passed = np.diff(seconds, prepend=seconds[0] - taken[0])
    if not ((passed > 0) & (passed < LONGEST)).all() or not ((taken > 0) & (taken < LONGEST)).all():
        raise _unusable(path, f"has times that do not increase by 0 to {LONGEST:g} s")
    names = gait.joint_names or tuple(joints)
    order = [names.index(joint) for joint in joints]
    for name in ("commanded", "measured", "load"):
        found[name] = found[name][:, order]
    commanded = found.pop("commanded")
    values = {name: one for name, _ in MEASURED if (one := _filled(found[name])) is not None}
    if not all(np.abs(one).max() < MOST for one in (*values.values(), commanded)):
        raise _unusable(path, "has values that are not finite, or impossible")
    if "measured" not in values:
        raise _unusable(path, "has no measured joint angles, as of servos on a bus")
    if (lasted := len(driven) / RATE) < SHORTEST:
        raise _unusable(path, f"has only {lasted:.1f} s besides rising and lying down")
    if "orientation" in values:
        values["orientation"][:, 2] = np.unwrap(values["orientation"][:, 2])
        if np.abs(values["orientation"][:, :2]).max() > FALLEN:
            raise _unusable(path, "has a robot that tips over")
    sent = np.concatenate([[seconds[0] - taken[0] - 1 / RATE], seconds[:-1]])
    span = slice(driven[0] + WARM, driven[-1] + 1)
    return Recorded(path, span, sent, seconds - taken, seconds, commanded, values, distance)


def _unusable(path: Path, what: str) -> GaitsimError:
    return GaitsimError(
        f"{path} {what}",
        allowed=f"at least {SHORTEST:g} s of this robot walking, better 60 s, as 'gaitsim drive' "
        "recorded them",
    )


def _filled(values: Floats) -> Floats | None:
    """Return values with their gaps interpolated, (frames, n); None if most are missing."""
    known = np.isfinite(values)
    if known.mean(axis=0).min() < LOST:
        return None
    frames = np.arange(len(values))
    gapless = [
        np.interp(frames, frames[there], one[there])
        for one, there in zip(values.T, known.T, strict=True)
    ]
    return np.stack(gapless, axis=1)


class RecordingReplay:
    """Simulations of the commands of recordings, window by window from measured states.

    Within a window, a simulation is started from the measured angles, tilt and rates, since a
    longer one would depend on the moments of single contacts.

    Args:
        robot: robot as it is assumed to be.
        recordings: drives of the real robot.
        workers: number of threads.

    Attributes:
        names: names of the parameters: those of `WORLD`, and the joints.
        start: values of the parameters at the start; horns in °.
        parameters: their steps and bounds.
    """

    def __init__(self, robot: Robot, recordings: Sequence[Recorded], workers: int) -> None:
        own = robot.conditions()
        self._plain = robot.model_copy(update={"world": {}, "horns": {}}).simulation
        self._world = {name: robot.world[name] for name in KEPT if name in robot.world}
        joints = self._plain.anatomy.joints
        self.names = (*WORLD, *joints)
        self.parameters = (*WORLD.values(), *[HORN] * len(joints))
        world = [robot.world.get(name, own[name].nominal) for name in WORLD]
        self.start = np.array([*world, *(robot.horns.get(name, 0.0) for name in joints)])
        self._recordings, self._workers = recordings, workers
        self._windows: list[tuple[Recorded, int]] = []
        for one in recordings:
            first, last = one.span.start, one.span.stop
            count = max((last - first) // WINDOW, 1)
            starts = np.linspace(first, last - WINDOW, count) if count > 1 else [first]
            self._windows += [(one, int(at)) for at in starts]

    @property
    def seconds(self) -> float:
        """Duration of all windows, s."""
        return len(self._windows) * WINDOW / RATE

    def residuals(self, values: Floats) -> Floats:
        """Return the measurements minus those of a simulation, averaged in blocks.

        Args:
            values: values of the parameters, (parameters,).

        Returns:
            The differences as multiples of the smallest deviations worth fitting,
            (windows, blocks, channels). The last channel is the relative error of the distance.
        """
        import mujoco
        from mujoco import rollout

        horns = np.radians(values[len(WORLD) :])
        *scales, latency = values[: len(WORLD)]
        # A design may step over a bound.
        fitted = dict(zip(WORLD, np.maximum(scales, LEAST), strict=False))
        simulation = apply_world(self._plain, {**self._world, **fitted}, horns)
        model, step = simulation.model, simulation.model.opt.timestep
        spans = [one.ended[at + WINDOW - 1] - one.read[at - WARM] for one, at in self._windows]
        steps = int(max(spans) / step) + 2
        begun = [self._begin(simulation, one, at - WARM) for one, at in self._windows]
        control = [
            self._control(
                simulation, one, one.read[at - WARM] - latency + step * np.arange(steps + 1)
            )
            for one, at in self._windows
        ]
        data = [mujoco.MjData(model) for _ in range(self._workers)]
        states, sensors = rollout.rollout(model, data, np.array(begun), np.array(control))
        found, moved = [], dict.fromkeys(map(id, self._recordings), 0j)
        for window, (one, at) in enumerate(self._windows):
            path = np.concatenate([begun[window][None], states[window]])
            simulated, advance = self._measure(simulation, one, at, path, sensors[window])
            found.append(self._compared(one, at, simulated))
            moved[id(one)] += advance
        return np.nan_to_num(self._with_distance(np.array(found), moved), posinf=1e6, neginf=-1e6)

    def _begin(self, simulation: Simulation, one: Recorded, at: int) -> Floats:
        """Return the state of a robot as it was measured in a frame, standing on the ground."""
        model, stance = simulation.model, simulation.anatomy.stance[3:7]
        state = simulation.start.copy()
        position, speed = state[1 : 1 + model.nq], state[1 + model.nq : 1 + model.nq + model.nv]
        angles = one.values["measured"]
        lower, upper = model.actuator_ctrlrange[simulation.ctrl].T
        position[simulation.qpos] = np.clip(angles[at] + simulation.offset, lower, upper)
        if "orientation" in one.values:
            position[3:7] = product(_quaternion(one.values["orientation"][at]), stance)
        position[2] -= lowest_points(model, position)[:, 2].min()
        speed[:] = 0.0
        past = one.read[at + 1] - one.read[at - 1]
        speed[simulation.dof] = (angles[at + 1] - angles[at - 1]) / past
        if "rates" in one.values:
            speed[3:6] = rotated(conjugate(stance), one.values["rates"][at])
        state[0] = 0.0
        return state

    def _control(self, simulation: Simulation, one: Recorded, edges: Floats) -> Floats:
        """Return the mean command between moments, (steps, servos): smooth in the latency."""
        before, after = one.sent[0] - 10.0, one.sent[-1] + 10.0
        times = np.array([before, *one.sent[1:], after])
        summed = np.cumsum(one.commanded * np.diff(times)[:, None], axis=0)
        summed = np.concatenate([np.zeros_like(summed[:1]), summed])
        means = (
            np.diff([np.interp(edges, times, joint) for joint in summed.T]).T / np.diff(edges)[0]
        )
        control = np.tile(simulation.rest, (len(means), 1))
        lower, upper = simulation.model.actuator_ctrlrange[simulation.ctrl].T
        control[:, simulation.ctrl] = np.clip(means + simulation.offset, lower, upper)
        return control

    def _measure(
        self, simulation: Simulation, one: Recorded, at: int, path: Floats, sensors: Floats
    ) -> tuple[dict[str, Floats], complex]:
        """Return what the robot measures in a window, and how far it walks, m + i m."""
        model, step, span = simulation.model, simulation.model.opt.timestep, slice(at, at + WINDOW)
        start = one.read[at - WARM]

        def moments(values: Floats, times: Floats, late: int = 0) -> Floats:
            place = (times[span] - start) / step - late
            whole = np.minimum(place.astype(np.intp), len(values) - 2)
            share = (place - whole)[:, None]
            return np.asarray((1 - share) * values[whole] + share * values[whole + 1])

        turned = orientation(simulation.turn(path[None, :, 4:8]))[0]
        spin = rotated(simulation.anatomy.stance[3:7], path[:, 4 + model.nq : 7 + model.nq])
        place = moments(path[:, 1:3], one.ended)
        found = {
            "measured": moments(path[:, 1 + simulation.qpos], one.read) - simulation.offset,
            # A servo reports the load of a moment before.
            "load": moments(sensors[:, simulation.torque], one.read, 1) / simulation.stall_torque,
            "orientation": moments(turned, one.ended),
            "rates": moments(spin, one.ended),
        }
        advance = complex(*(place[-1] - place[0]))
        if "orientation" in one.values:  # in the direction of the real robot
            drift = one.values["orientation"][at, 2] - found["orientation"][0, 2]
            advance *= np.exp(1j * drift)
        return found, advance

    def _compared(self, one: Recorded, at: int, simulated: Mapping[str, Floats]) -> Floats:
        """Return the differences of a window in blocks, (blocks, channels)."""
        parts = []
        for name, least in MEASURED:
            given = one.values.get(name)
            values = simulated[name]
            part = np.zeros_like(values) if given is None else given[at : at + WINDOW] - values
            # The yaw depends on all contacts since the start; its rate is compared.
            parts.append((part[:, :2] if name == "orientation" else part) / least)
        found = np.concatenate(parts, axis=1)
        return np.asarray(found.reshape(-1, BLOCK, found.shape[1]).mean(axis=1))

    def _with_distance(self, found: Floats, moved: Mapping[int, complex]) -> Floats:
        error = np.zeros((*found.shape[:2], 1))
        for window, (one, _) in enumerate(self._windows):
            if one.distance > 0:
                error[window] = (1 - abs(moved[id(one)]) / one.distance) / DISTANCE
        return np.concatenate([found, error], axis=2)


def _quaternion(turned: Floats) -> Floats:
    """Return the rotation with a roll, pitch and yaw, (3,), as a quaternion, (4,)."""
    roll, pitch, yaw = (turn_about(axis, turned[at]) for at, axis in enumerate(np.eye(3)))
    return product(yaw, product(pitch, roll))


@dataclass(frozen=True, eq=False)
class Identified:
    """The parameters of a robot that were found.

    Attributes:
        names: names of the parameters: those of `WORLD`, and the joints.
        start: values that were assumed, (parameters,); horns in °.
        values: values that fit best, (parameters,).
        errors: standard errors, (parameters,), from resampled windows and the last change.
        misfit: typical deviation of the assumed robot and of the fitted one from the measurements,
            relative to what is worth fitting.
    """

    names: tuple[str, ...]
    start: Floats
    values: Floats
    errors: Floats
    misfit: tuple[float, float]

    @property
    def world(self) -> dict[str, float]:
        """The fitted conditions of the world."""
        return {name: _rounded(one) for name, one in zip(WORLD, self.values, strict=False)}

    @property
    def horns(self) -> dict[str, float]:
        """The errors of the horns by joint, °."""
        joints = slice(len(WORLD), None)
        return dict(zip(self.names[joints], np.round(self.values[joints], 2).tolist(), strict=True))

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The 95 % intervals of the conditions, and of what remains of the horns' errors."""
        found = {
            name: (_rounded(max(value - 2 * error, one.low)), _rounded(value + 2 * error))
            for (name, one), value, error in zip(
                WORLD.items(), self.values, self.errors, strict=False
            )
        }
        return {**found, "joint_offset": (0.0, _rounded(float(self.errors[len(WORLD) :].mean())))}


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


FIRST = 2  # rounds that change only the world
MEMORY = 0.5  # share of the slopes of earlier rounds
SHRINK, SMALLEST = 0.85, 0.3  # of the steps from round to round
SHARES = (0.5, 1.0, 2.0, 4.0)  # of the step of a linear model, which noise shortens


def simulations(rounds: int, parameters: int) -> int:
    """Return the number of simulations of `identify`."""
    first = FIRST * (_size(len(WORLD)) + len(SHARES))
    return 1 + first + rounds * (_size(parameters) + len(SHARES))


def _size(parameters: int) -> int:
    """Return the number of simulations of a design: a power of two above the parameters."""
    return 1 << parameters.bit_length()


def identify(
    replay: RecordingReplay, rounds: int, advance: Callable[[], object], seed: int = 0
) -> tuple[Identified, bool]:
    """Fit the parameters of a robot; return them, and whether KeyboardInterrupt ended the fit.

    Each round simulates a two-level design, in which all parameters change together (Plackett and
    Burman 1946, "The design of optimum multifactorial experiments"): the slope for each parameter
    is a mean over all simulations. Changing one parameter at a time would need many times as many
    for the same accuracy, since contacts make small changes noisy. A linear model then gives the
    next values, with robust weights (Student's t). The first rounds change only the world.

    Args:
        replay: simulations of the recordings.
        rounds: number of rounds.
        advance: function called after each simulation.
        seed: seed of the designs.
    """
    rng, count = np.random.default_rng(seed), len(replay.names)
    steps, spread, low, high = np.array(
        [(one.step, one.spread, one.low, one.high) for one in replay.parameters]
    ).T
    prior = np.diag(1 / np.square(spread))

    def simulate(values: Floats) -> Floats:
        found = replay.residuals(values)
        advance()
        return found

    values, errors, stopped, before = replay.start.copy(), spread, False, np.empty(0)
    residuals = simulate(values)
    first = misfit = _misfit(residuals)
    try:
        for number in range(-FIRST, rounds):
            changed = len(WORLD) if number < 0 else count
            width = steps * max(SHRINK ** max(number, 0), SMALLEST)
            design = np.zeros((_size(changed), count))
            signs = rng.choice([-1.0, 1.0], changed)
            design[:, :changed] = _hadamard(len(design))[:, 1 : changed + 1] * signs
            tried = np.array([simulate(values + row * width) for row in design])
            slopes = np.tensordot(design, tried, (0, 0)) / len(tried) / width[(...,) + (None,) * 3]
            if number > 0:  # slopes hardly change from round to round, but their noise does
                slopes = MEMORY * before + (1 - MEMORY) * slopes
            before = slopes
            hessian, gradient = _normal_equations(residuals, np.moveaxis(slopes, 0, -1))
            pull = prior @ (values - replay.start)
            move = -np.linalg.solve(hessian.sum(axis=0) + prior, gradient.sum(axis=0) + pull)
            errors, last = _bootstrap(hessian, gradient, prior, rng), values
            for share in SHARES:
                tried_values = np.clip(last + share * move, low, high)
                found = simulate(tried_values)
                if (other := _misfit(found)) < misfit:
                    values, residuals, misfit = tried_values, found, other
            errors = np.hypot(errors, np.abs(values - last))
    except KeyboardInterrupt:
        stopped = True
    errors = np.hypot(errors, [one.floor for one in replay.parameters])
    return Identified(replay.names, replay.start, values, errors, (first, misfit)), stopped


def _hadamard(size: int) -> Floats:
    """Return Sylvester's matrix of ±1 with orthogonal columns, (size, size)."""
    found = np.ones((1, 1))
    while len(found) < size:
        found = np.block([[found, found], [found, -found]])
    return found


def _misfit(residuals: Floats) -> float:
    """Return the geometric mean over channels of the mean deviation, at least 1 for each."""
    return float(np.exp(np.log(np.maximum(np.abs(residuals).mean(axis=(0, 1)), 1.0)).mean()))


def _normal_equations(residuals: Floats, slopes: Floats) -> tuple[Floats, Floats]:
    """Return the weighted normal equations of each window, (windows, n, n) and (windows, n)."""
    scale = np.maximum(np.abs(residuals).mean(axis=(0, 1)), 1.0)
    weight = 1 / (np.square(scale) + np.square(residuals) / 4)
    weighted = slopes * weight[..., None]
    return (
        np.einsum("wbci,wbcj->wij", weighted, slopes, optimize=True),
        np.einsum("wbci,wbc->wi", weighted, residuals),
    )


def _bootstrap(
    hessian: Floats, gradient: Floats, prior: Floats, rng: np.random.Generator, draws: int = 100
) -> Floats:
    """Return the standard deviation of the solution over resampled windows, (parameters,)."""
    windows = len(hessian)
    found = []
    for _ in range(draws):
        chosen = rng.integers(windows, size=windows)
        matrix = hessian[chosen].sum(axis=0) + prior
        found.append(np.linalg.solve(matrix, gradient[chosen].sum(axis=0)))
    inverse = np.linalg.inv(hessian.sum(axis=0) + prior)
    return np.asarray(np.sqrt(np.var(found, axis=0) + np.diag(inverse)))
