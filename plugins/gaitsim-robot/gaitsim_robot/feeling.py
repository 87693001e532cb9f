"""Gaits that feel: sensors, reflexes and a driver's commands change the rhythm in each frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    COMMAND,
    REFLEX,
    GaitsimError,
    Inputs,
    Legs,
    Observation,
    Reflex,
    Rhythm,
    call_reflex,
    contract_error,
    find,
    unknown,
)
from gaitsim.plugin.toolkit import FEET_AND_JOINTS, IMUS, GeneGroup, Imu, observed

Floats = NDArray[np.float64]

SMOOTHING = 0.2  # s, time constant with which the rhythm follows a changed command
HOLD = 0.2  # s, how long the last valid measurement replaces an invalid one before the robot stops


@dataclass(eq=False)
class Truth:
    """Exact values of the quantities that sensors measure.

    Attributes:
        orientation: roll to the right, pitch nose down and yaw to the left since the start,
            (population, 3) rad.
        rates: angular velocity about the trunk's axes, (population, 3) rad/s.
        load: vertical force on each foot as a share of the weight, (population, legs).
        joints: joint angles, (population, joints) rad.
    """

    orientation: Floats
    rates: Floats
    load: Floats
    joints: Floats


class Pilot:
    """The controllers of a population that walks in lock step.

    Args:
        rhythm: rhythms of the population.
        reflexes: reflexes by name, in the order in which they act.
        weights: genes of the reflexes by name, (population, weights) each.
        sensors: names of the sensors.
        world: conditions of the world, whose seed draws the errors of the sensors.
        frames: number of frames for which errors are drawn.
        interval: duration of a frame, s.

    Attributes:
        rhythm: rhythms of the individuals that still walk.
        command: smoothed command, (population, 4).
        heading: direction that the commands ask for, (population,) rad.
        inputs: inputs of the rhythm in the last frame.
        seen: observations in the last frame.
        failures: reasons by individual, whose reflexes gave invalid inputs in the last frame.
    """

    inputs: Inputs
    seen: Observation
    failures: dict[int, str]

    def __init__(
        self,
        rhythm: Rhythm,
        reflexes: Mapping[str, Reflex],
        weights: Mapping[str, Floats],
        sensors: Sequence[str],
        world: Mapping[str, float],
        frames: int,
        interval: float,
    ) -> None:
        from gaitsim_robot.rhythm import RhythmState, advance  # Numba takes a while to import

        self._advance = advance
        self.rhythm, self._interval = rhythm, interval
        self._state = RhythmState(rhythm)
        self._reflexes = dict(reflexes)
        self._states = {
            name: started(name, reflex, rhythm.legs, weights[name])
            for name, reflex in reflexes.items()
        }
        imu: Imu = next((IMUS[name] for name in sensors if name in IMUS), IMUS["ideal"])
        self._errors = imu.draw(world, frames, interval)
        self._late = imu.delay / interval
        self._history: list[Floats] = []
        numbers = 6 + len(rhythm.names) + len(rhythm.standing)
        self._last = np.zeros((len(rhythm), numbers))
        self._invalid = np.zeros(len(rhythm))
        self.command = np.zeros((len(rhythm), len(COMMAND)))
        self.heading = np.zeros(len(rhythm))

    def step(self, frame: int, target: Floats, truth: Truth) -> Floats:
        """Return the joint angles to command, (population, joints) rad.

        Args:
            frame: number of the frame.
            target: command of the driver, (population, 4), as `COMMAND`; 0 is to stand.
            truth: exact values of the measurements.
        """
        orientation, rates, load, joints = self._measure(frame, truth)
        target = np.where(self._invalid[:, None] > HOLD, 0.0, target)
        share = min(self._interval / SMOOTHING, 1.0)
        self.command += share * (target - self.command)
        rhythm, state = self.rhythm, self._state
        walking = (target[:, :3] != 0).any(axis=1)
        self.command[~walking & (state.activity == 0), :3] = 0.0
        seen = self.seen = Observation(
            orientation,
            rates,
            (load > 0).astype(np.float64),
            load,
            joints,
            self.command.view(),
            self.heading.view(),
            state.phase(rhythm),
            rhythm.duty[:, None],
        )
        self.inputs = Inputs.unchanged(self.command, len(rhythm.names))
        for values in vars(seen).values():
            values.flags.writeable = False
        self.failures = {}
        for name, reflex in self._reflexes.items():
            self._act(name, reflex)
        angles = self._advance(rhythm, state, walking, self.inputs, self._interval)
        self.heading += self.command[:, 1] * state.scale * state.activity * self._interval
        return angles

    def _act(self, name: str, reflex: Reflex) -> None:
        """Let a reflex change the inputs; where it makes them invalid, record the failure."""
        inputs, state = self.inputs, self._states[name]
        before = (*vars(inputs).values(), *state.values())
        step = reflex.step
        call_reflex(
            name, "advancing a control step", step, state, self.seen, inputs, self._interval
        )
        after = (*vars(inputs).values(), *state.values())
        # The compiled rhythm reads arrays without a check of their bounds.
        if [*map(id, after)] != [*map(id, before)]:
            what = "replaced an array of its state or of the inputs in a control step"
            allowed = "changes in place, such as inputs.reach[:] = …, or state['x'] += …"
            raise contract_error(find(REFLEX, name), what, allowed)
        for part, values in vars(inputs).items():
            valid = np.isfinite(values).all(axis=1)
            if not valid.all():
                values[~valid] = 1.0 if part in ("stride", "rate") else 0.0
                for individual in np.flatnonzero(~valid):
                    what = f"the reflex {name!r} made the input {part!r} infinite or NaN"
                    self.failures.setdefault(int(individual), what)

    def _measure(self, frame: int, truth: Truth) -> list[Floats]:
        """Return orientation, rates, load and joints with the errors of the IMU.

        If any number is invalid, as with a loose wire, all are those of the last valid measurement.
        """
        true = np.concatenate([truth.orientation, truth.rates], axis=1)
        self._history = [true, *self._history[: int(self._late) + 1]]
        whole, share = int(self._late), self._late - int(self._late)
        measured = self._history[min(whole, len(self._history) - 1)]
        if share:
            before = self._history[min(whole + 1, len(self._history) - 1)]
            measured = measured + share * (before - measured)
        felt = np.concatenate(
            [self._errors.measure(measured, frame), truth.load, truth.joints], axis=1
        )
        valid = np.isfinite(felt).all(axis=1)
        if not valid.all():
            felt[~valid] = self._last[~valid]
        self._invalid = np.where(valid, 0.0, self._invalid + self._interval)
        self._last = felt
        return np.split(felt, [3, 6, 6 + truth.load.shape[1]], axis=1)

    @property
    def scale(self) -> float:
        """Smallest factor of strokes that were too long in the last frame; 1 without any."""
        return float(self._state.scale.min())

    def select(self, individuals: NDArray[Any]) -> None:
        """Keep some individuals, such as those that have not fallen."""
        self.rhythm = self.rhythm.select(individuals)
        self._state = self._state.select(individuals)
        self._states = {
            name: {key: value[individuals] for key, value in state.items()}
            for name, state in self._states.items()
        }
        self._reflexes = {
            name: select_options(reflex, individuals) for name, reflex in self._reflexes.items()
        }
        self._history = [one[individuals] for one in self._history]
        for name in ("_last", "_invalid", "command", "heading"):
            setattr(self, name, getattr(self, name)[individuals])


@dataclass(frozen=True, eq=False)
class ReflexGenes:
    """The reflexes of a body, and the genes that their options and weights add to its genome.

    Attributes:
        reflexes: reflexes by name, in the order in which they act.
        evolve: options that are genes, such as 'heading.gain'.
        legs: legs of the body.
    """

    reflexes: Mapping[str, Reflex]
    evolve: tuple[str, ...]
    legs: Legs

    @property
    def _options(self) -> list[list[str]]:
        """The names of reflex and option of each gene of an option."""
        return [gene.split(".") for gene in self.evolve]

    @property
    def groups(self) -> tuple[GeneGroup, ...]:
        """The gene groups."""
        found = []
        for owner, option in self._options:
            low, high = bounds(type(self.reflexes[owner]).model_fields[option].metadata)
            found.append(GeneGroup(f"{owner} {option}".replace("_", " "), ("",), low, high))
        for name, reflex in self.reflexes.items():
            if count := weight_count(name, reflex, self.legs):
                parts = tuple(str(1 + n) for n in range(count))
                found.append(GeneGroup(f"{name} weight", parts, -1.0, 1.0))
        return tuple(found)

    @property
    def start(self) -> Floats:
        """The genes of the options as they are, and of weights of 0, (genes,)."""
        options = [getattr(self.reflexes[owner], option) for owner, option in self._options]
        weights = sum(weight_count(*named, self.legs) for named in self.reflexes.items())
        return np.concatenate([options, np.zeros(weights)])

    def decode(self, genes: Floats) -> tuple[dict[str, Reflex], dict[str, Floats]]:
        """Return the reflexes with evolved options, (population,) each, and weights by name."""
        found, first = dict(self.reflexes), len(self.evolve)
        for column, (owner, option) in enumerate(self._options):
            found[owner] = found[owner].model_copy(update={option: genes[:, column].copy()})
        weights = {}
        for name, reflex in self.reflexes.items():
            count = weight_count(name, reflex, self.legs)
            weights[name], first = genes[:, first : first + count], first + count
        return found, weights


NO_REFLEXES = ReflexGenes({}, (), Legs((), np.zeros((0, 2)), 0.0, 0))


def bounds(metadata: Sequence[Any]) -> tuple[float, float]:
    """Return the bounds of an option from its constraints; infinite without one."""
    limits = {name: math.inf if name[0] == "l" else -math.inf for name in ("ge", "gt", "le", "lt")}
    for one in metadata:
        for name in limits:
            if getattr(one, name, None) is not None:
                limits[name] = float(getattr(one, name))
    return max(limits["ge"], limits["gt"]), min(limits["le"], limits["lt"])


def check_evolve(
    evolve: Sequence[str], reflexes: Mapping[str, Reflex], dimensions: Sequence[str]
) -> None:
    """Check that names such as 'heading.gain' are numbers with bounds among the options.

    Args:
        evolve: names that are not dimensions.
        reflexes: reflexes by name.
        dimensions: names of the dimensions, for messages.

    Raises:
        GaitsimError: a name is unknown, or given twice.
    """
    known = [
        f"{name}.{option}"
        for name, reflex in reflexes.items()
        for option, field in type(reflex).model_fields.items()
        if field.annotation is float and np.isfinite(bounds(field.metadata)).all()
    ]
    owners = {name.partition(".")[0] for name in dimensions}
    for name in evolve:
        if "." in name and name.partition(".")[0] not in owners and not reflexes:
            raise GaitsimError(
                f"the robot has no reflexes, whose options {', '.join(evolve)} could evolve",
                remedy="add reflexes to organism.reflexes, or remove organism.evolve",
                key="evolve",
            )
        if name not in known:
            what = "dimension or option of a reflex" if reflexes else "dimension"
            raise unknown(what, name, [*known, *dimensions], key="evolve")
    if len({*evolve}) < len(evolve):
        raise GaitsimError(
            f"an option of a reflex is listed twice: {', '.join(evolve)}",
            allowed="each option at most once",
            key="evolve",
        )


def check_needs(reflexes: Mapping[str, Reflex], sensors: Sequence[str]) -> None:
    """Check that the sensors make the observations that reflexes need.

    Raises:
        GaitsimError: an observation is missing; the message has the sensors of the robot.
    """
    has = observed(sensors)
    for name, reflex in reflexes.items():
        missing = [need for need in reflex.needs if need not in has]
        if missing:
            helps = [one for one in (*IMUS, *FEET_AND_JOINTS) if missing[0] in observed([one])]
            raise GaitsimError(
                f"the reflex {name!r} needs {missing[0]}, which this robot does not sense",
                where=f"organism.sensors: {', '.join(sensors) or 'none'}",
                allowed=f"a sensor of {missing[0]}: {', '.join(helps)}",
                remedy=f"add one to organism.sensors, if the robot has it, or remove {name!r}",
                key="reflexes",
            )


MOST_WEIGHTS = 100_000


def weight_count(name: str, reflex: Reflex, legs: Legs) -> int:
    """Return the number of weights of a reflex.

    Raises:
        GaitsimError: the reflex fails, or the number is invalid.
    """
    count: object = call_reflex(name, "returning its number of weights", reflex.weights, legs)
    if not isinstance(count, int) or not 0 <= count <= MOST_WEIGHTS:
        allowed = f"a whole number from 0 to {MOST_WEIGHTS:,}"
        raise contract_error(find(REFLEX, name), f"has {count!r:.60} weights", allowed)
    return count


def started(name: str, reflex: Reflex, legs: Legs, weights: Floats) -> dict[str, Floats]:
    """Return the state of a reflex at the start.

    Raises:
        GaitsimError: the reflex fails, or the state is not arrays (population, …).
    """
    state: object = call_reflex(name, "starting", reflex.start, legs, weights)
    if not isinstance(state, dict) or not all(
        isinstance(values, np.ndarray) and values.shape[:1] == (len(weights),)
        for values in state.values()
    ):
        what = "returned an invalid state at the start"
        allowed = "a dict of arrays with one row for each individual, (population, …)"
        raise contract_error(find(REFLEX, name), what, allowed)
    return state


def select_options(reflex: Reflex, individuals: NDArray[Any] | int) -> Reflex:
    """Return a reflex with the evolved options, (population,) each, of some individuals or one."""
    evolved = {
        name: value[individuals]
        for name in type(reflex).model_fields
        if isinstance(value := getattr(reflex, name), np.ndarray)
    }
    return reflex.model_copy(update=evolved) if evolved else reflex
