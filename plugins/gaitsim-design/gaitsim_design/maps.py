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
"""Assumed continuous torque as a share of the stall torque, if the servos' own is unknown."""


@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity of the best gaits.

    Attributes:
        unit: unit, or ''.
        higher: whether higher values are better.
        values: values, (designs, replicates); NaN where a design has no gait.
        original: index of the original.
    """

    unit: str
    higher: bool
    values: Floats
    original: int

    @cached_property
    def means(self) -> Floats:
        """The means over replicates, (designs,)."""
        return intervals(self.values)[0]

    @cached_property
    def half_widths(self) -> Floats:
        """The half widths of the 95 % intervals of the means, (designs,)."""
        return intervals(self.values)[1]

    @cached_property
    def differs(self) -> NDArray[np.int64]:
        """Whether designs are above (1) or below (−1) the original beyond the noise, (designs,)."""
        return differences(self.values, self.original)

    @property
    def best(self) -> int:
        """The index of the design with the best mean."""
        ordered = self.means if self.higher else -self.means
        return int(np.where(np.isfinite(ordered), ordered, -np.inf).argmax())


class ServoLoad(NamedTuple):
    """The load of a servo with a gait: heat, peak torque as a share of the stall torque, speed."""

    servo: str
    heat: float
    peak: float
    speed: float
    lasted: bool

    @property
    def holds(self) -> bool:
        """Whether the robot stays on its feet, and the servo does not overheat."""
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
        search = designs_search(run)
        if run.checkpoint is None:
            raise unfinished_error(run.path)
        _ = run.members  # checks the state
        if not search.has_designs(run.finished.state):
            raise NothingToPlotError(
                f"the run {run.path} still evolves gaits of the original",
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
        if not ((continuous > 0) & (stall > 0)).all():
            return CONTINUOUS, False
        return float((continuous / stall).min()), True

    @cached_property
    def quantities(self) -> Mapping[str, Quantity]:
        """The score and the measures of the best gait of each design and replicate, by name."""
        state = self.run.finished.state
        known = dict(zip(self.search.reads(), state["values"].T, strict=True))
        columns = {"score": (self.experiment.fitness.unit, True, state["scores"])}
        if SPEED in known:
            columns[SPEED] = "m/s", True, known[SPEED]
        if COST in known:
            columns[COST] = "", False, known[COST]
        if TORQUE in known and np.nanmax(known[TORQUE], initial=0.0) > 0:
            columns[HEAT] = "of continuous torque", False, known[TORQUE] / self.heat_share[0]
        if PEAK in known:
            columns[PEAK] = "of stall torque", False, known[PEAK]
        found = {}
        for name, (unit, higher, column) in columns.items():
            values = np.where(self.walks, column.reshape(-1, len(self.designs)).T, np.nan)
            found[name] = Quantity(unit, higher, values, self.original)
        return found

    @property
    def walks(self) -> NDArray[np.bool_]:
        """Whether each design has a gait in each replicate, (designs, replicates)."""
        scores = self.run.finished.state["scores"].reshape(-1, len(self.designs)).T
        return np.asarray(np.isfinite(scores))

    @property
    def held(self) -> NDArray[np.int64]:
        """The index of the design of each member of the run, (members,)."""
        return np.flatnonzero(self.walks.any(axis=1))

    @property
    def best(self) -> int:
        """The index of the design with the highest mean score."""
        return self.quantities["score"].best

    @cached_property
    def plateau(self) -> NDArray[np.bool_]:
        """The designs that cannot be distinguished from the best by their scores, (designs,)."""
        return plateau(self.quantities["score"].values)

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
        return int(np.searchsorted(self.held, design)) + 1 if design in self.held else 0

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
        """Designs to look at, by their roles: the original, the best, the least cost and heat."""
        wanted = {"original": self.original, "best score": self.best}
        for name, quantity in self.quantities.items():
            if not quantity.higher and name != PEAK:
                wanted[f"least {name}"] = quantity.best
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
        if "servo" not in fields or HEAT not in self.quantities:
            return {}
        genomes, each = self.genomes[[*self.chosen.values()]], []
        for servo in SERVOS.values():
            body = with_body(self.experiment, {"organism.servo": servo.name})
            motion = move_genomes(body, genomes)
            measures = body.organism.measures(motion)
            torque, peak, speed = (measures[name].values for name in (TORQUE, PEAK, SPEED))
            ends = (motion["torso"].shape[1] - 1) / motion.frame_rate
            lasted = measures["lasted"].values > ends - 0.5 / motion.frame_rate
            columns = (torque / servo.continuous, peak, speed, lasted)
            rows = zip(*(column.tolist() for column in columns), strict=True)
            each.append([ServoLoad(servo.name, *row) for row in rows])
        return dict(zip(self.chosen, zip(*each, strict=True), strict=True))


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
