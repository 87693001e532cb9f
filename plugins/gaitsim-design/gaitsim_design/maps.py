"""A map of designs: the gaits, measures and statistics of a run of the search `designs`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Dimension, NothingToPlotError, RunError
from gaitsim.plugin.gait import with_body
from gaitsim.plugin.runs import (
    Experiment,
    Individual,
    Member,
    RunSnapshot,
    command,
    evaluate_experiment,
    move_genomes,
    unfinished_error,
)
from gaitsim.plugin.toolkit import SERVOS
from gaitsim_design.search import Designs
from gaitsim_design.statistics import Floats, differences, intervals, plateau

SPEED, COST, TORQUE, PEAK = "speed", "cost of transport", "RMS torque", "peak torque"
MEASURES = SPEED, COST, TORQUE, PEAK
"""The measures that a map records, if the body has them."""

HEAT = "heat"
CONTINUOUS = 0.2
"""Assumed continuous torque as a share of the stall torque, if the servos' own is unknown: that of
the hobby servos in the table."""

ROBOTS_SERVO = "servo"


class Quantity(NamedTuple):
    """A quantity of gaits: its unit, whether higher is better, and its values.

    Attributes:
        unit: unit, or ''.
        higher: whether higher values are better.
        values: values, (designs, replicates); NaN where a design has no gait.
    """

    unit: str
    higher: bool
    values: Floats


@dataclass(frozen=True, eq=False)
class ServoLoad:
    """The load of a servo with the best gait of a design.

    Attributes:
        servo: name of the servo.
        heat: RMS torque of the hottest servo as a share of its continuous torque.
        peak: largest mean torque of a frame, 20 ms, as a share of the stall torque.
        speed: speed, m/s.
        lasted: whether the body did not fall.
    """

    servo: str
    heat: float
    peak: float
    speed: float
    lasted: bool

    @property
    def holds(self) -> bool:
        """Whether the servo walks this gait without overheating."""
        return self.lasted and self.heat <= 1


@dataclass(frozen=True, eq=False)
class DesignMap:
    """The designs of a body with their best gaits, in independent replicates.

    Attributes:
        run: run of the search `designs`.
    """

    run: RunSnapshot

    @classmethod
    def of(cls, run: RunSnapshot) -> "DesignMap":
        """Return the map of a run.

        Raises:
            RunError: the run has no designs yet, or its search is another one.
        """
        designs_search(run)
        if run.checkpoint is None:
            raise unfinished_error(run.path)
        _ = run.members  # checks the state
        if not len(run.finished.state["genomes"]):
            raise NothingToPlotError(
                f"the run {run.path} still searches for gaits of the original",
                remedy=f"continue it: {command('design', run.path)}",
            )
        return cls(run)

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self.run.experiment

    @property
    def search(self) -> Designs:
        """The search."""
        return designs_search(self.run)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the dimensions."""
        return self.search.dimensions

    @cached_property
    def dimensions(self) -> Mapping[str, Dimension]:
        """The dimensions of the body by name."""
        space = self.experiment.organism.design_space()
        return {name: space[name] for name in self.names}

    @cached_property
    def designs(self) -> Floats:
        """The factors of the designs, (designs, dimensions)."""
        return np.asarray(self.run.finished.state["designs"])

    @property
    def original(self) -> int:
        """The index of the original."""
        return int(np.flatnonzero((self.designs == 1).all(axis=1))[0])

    @property
    def grid(self) -> NDArray[np.int64] | None:
        """The index of each design of a grid of two dimensions, (first, second); else None.

        An original between the lines of the grid is left out.
        """
        if self.search.sample or len(self.names) != 2:
            return None
        count = self.search.levels**2
        indices = np.arange(len(self.designs) - count, len(self.designs))
        return indices.reshape(self.search.levels, -1)

    @property
    def points(self) -> Floats:
        """The designs, (designs, dimensions), scaled from their ranges to −1 to 1."""
        low, high = self.designs.min(axis=0), self.designs.max(axis=0)
        return np.asarray(2 * (self.designs - low) / (high - low) - 1)

    @cached_property
    def heat_share(self) -> tuple[float, bool]:
        """The continuous torque of the servos as a share of the stall torque; whether it is known.

        It is that of the joint with the smallest share.
        """
        motion = move_genomes(self.experiment, self.genomes[self.original][None])
        names = "continuous_torque", "stall_torque"
        if not {*names} <= {*self.experiment.organism.channels}:
            return CONTINUOUS, False
        continuous, stall = (np.asarray(motion[name][0]) for name in names)
        known = (continuous > 0) & (stall > 0)
        if not known.all():
            return CONTINUOUS, False
        return float((continuous / stall).min()), True

    @cached_property
    def quantities(self) -> Mapping[str, Quantity]:
        """The score and the measures of the best gait of each design and replicate, by name."""
        state, count = self.run.finished.state, len(self.designs)

        def table(values: Floats) -> Floats:
            found = values.reshape(-1, count).T
            return np.where(self.walks, found, np.nan)

        found = {"score": Quantity(self.experiment.fitness.unit, True, table(state["scores"]))}
        columns = dict(zip(self.search.reads(), state["values"].T, strict=True))
        if SPEED in columns:
            found[SPEED] = Quantity("m/s", True, table(columns[SPEED]))
        if COST in columns:
            found[COST] = Quantity("", False, table(columns[COST]))
        if TORQUE in columns and np.nanmax(columns[TORQUE], initial=0.0) > 0:
            heat = table(columns[TORQUE]) / self.heat_share[0]
            found[HEAT] = Quantity("of continuous torque", False, heat)
        if PEAK in columns:
            found[PEAK] = Quantity("of stall torque", False, table(columns[PEAK]))
        return found

    @property
    def walks(self) -> NDArray[np.bool_]:
        """Whether each design has a gait in each replicate, (designs, replicates)."""
        scores = self.run.finished.state["scores"].reshape(-1, len(self.designs)).T
        return np.asarray(np.isfinite(scores))

    @property
    def scores(self) -> Floats:
        """The scores, (designs, replicates); NaN without a gait."""
        return self.quantities["score"].values

    @property
    def best(self) -> int:
        """The index of the design with the highest mean score."""
        return self.leading("score")

    def leading(self, name: str) -> int:
        """Return the index of the design with the best mean of a quantity."""
        quantity = self.quantities[name]
        means = quantity.values.mean(axis=1)
        worst = -np.inf if quantity.higher else np.inf
        ordered = np.where(np.isfinite(means), means, worst)
        return int(ordered.argmax() if quantity.higher else ordered.argmin())

    @property
    def plateau(self) -> NDArray[np.bool_]:
        """Which designs cannot be distinguished from the best by their scores, (designs,)."""
        return plateau(self.scores)

    def differs(self, name: str) -> NDArray[np.int64]:
        """Return which designs differ from the original by more than the noise, (designs,)."""
        return differences(self.quantities[name].values, self.original)

    def summary(self, name: str) -> tuple[Floats, Floats]:
        """Return means and half widths of 95 % intervals of a quantity, (designs,) each."""
        return intervals(self.quantities[name].values)

    @cached_property
    def genomes(self) -> NDArray[Any]:
        """The gait of the best replicate of each design, (designs, genes)."""
        state = self.run.finished.state
        rows = self.search.best(state) * len(self.designs) + np.arange(len(self.designs))
        return np.asarray(state["genomes"][rows])

    def failures(self) -> dict[int, str]:
        """Return why designs without any gait fail, by index."""
        failed = np.flatnonzero(~self.walks.any(axis=1))
        if not len(failed):
            return {}
        reasons = evaluate_experiment(self.experiment, self.genomes[failed]).reasons
        return {int(failed[index]): reason for index, reason in reasons.items()}

    def member(self, design: int) -> int:
        """Return the number of a design among the members of the run, from 1; 0 without a gait."""
        held = np.asarray(self.walks.any(axis=1))
        return int(held[: design + 1].sum()) if held[design] else 0

    def individual(self, design: int) -> Individual:
        """Return the individual with the best gait of a design."""
        return self.run.individual(Member(self.member(design)))

    def label(self, design: int) -> str:
        """Return the factors of a design with the lengths, such as 'thigh 1.1 (0.121 m)'."""
        return ", ".join(
            f"{name} {factor:.3g} ({factor * one.nominal:.3g} {one.unit})".replace(" )", ")")
            for (name, one), factor in zip(
                self.dimensions.items(), self.designs[design].tolist(), strict=True
            )
        )

    @cached_property
    def chosen(self) -> Mapping[str, int]:
        """Designs to look at, by what they are: the original, the best, the least cost and heat."""
        wanted = {"original": self.original, "best score": self.best}
        for name, quantity in self.quantities.items():
            if not quantity.higher and name != PEAK:
                wanted[f"least {name}"] = self.leading(name)
        found: dict[int, list[str]] = {}
        for name, index in wanted.items():
            found.setdefault(index, []).append(name)
        return {", ".join(names): index for index, names in found.items()}

    @cached_property
    def servo_loads(self) -> Mapping[str, tuple[ServoLoad, ...]]:
        """The loads of the servos of the table with the gaits of `chosen`, by its names.

        {} for a body that has no choice of servos.
        """
        fields = type(self.experiment.organism).model_fields
        if ROBOTS_SERVO not in fields or TORQUE not in self.search.measures:
            return {}
        found: dict[str, list[ServoLoad]] = {name: [] for name in self.chosen}
        genomes = self.genomes[[*self.chosen.values()]]
        for servo in SERVOS.values():
            body = with_body(self.experiment, {f"organism.{ROBOTS_SERVO}": servo.name})
            motion = move_genomes(body, genomes)
            measures = body.organism.measures(motion)
            ends = len(motion["torso"][0]) - 1
            for index, loads in enumerate(found.values()):
                value = {
                    name: float(measures[name].values[index]) for name in (*MEASURES, "lasted")
                }
                whole = value["lasted"] >= ends / motion.frame_rate - 1e-9
                heat = value[TORQUE] / servo.continuous
                loads.append(ServoLoad(servo.name, heat, value[PEAK], value[SPEED], whole))
        return {name: tuple(loads) for name, loads in found.items()}


def designs_search(run: RunSnapshot) -> Designs:
    """Return the search of a run, which must be a map of designs.

    Raises:
        RunError: its search is another one.
    """
    found = run.experiment.search
    if not isinstance(found, Designs):
        raise RunError(
            f"{run.path} is not a map of designs: its search is "
            f"{run.experiment.entries['search'].name!r}",
            remedy="'gaitsim design BODY' computes a map",
        )
    return found
