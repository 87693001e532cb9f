"""One genome with its score, and how its body moves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion, Skeleton
from gaitsim.evaluation.scoring import Evaluation, evaluate, evaluate_motion
from gaitsim.evaluation.worlds import World, describe
from gaitsim.experiment import WORLD, Experiment
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.registry.python_plugins import MissingFitness
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.toml import brief


class Measurement(NamedTuple):
    """One measure of a motion: its value, unit and meaning."""

    value: float
    unit: str
    help: str


@dataclass(frozen=True)
class Member:
    """An individual that a search keeps, of its front or archive, by its number from 1."""

    number: int

    def __str__(self) -> str:
        return f"member {self.number}"


@dataclass(frozen=True)
class Near:
    """The best member of a front or archive whose values are near given ones, by axis.

    Distances are in shares of an axis, the greatest of the axes counts. Members count as near
    whose distance is at most `WITHIN` more than the least, and the one with the highest score is
    chosen.
    """

    values: Mapping[str, float]

    def __str__(self) -> str:
        return ", ".join(f"{name}={value:g}" for name, value in self.values.items())


WITHIN = 0.05

Which = int | Member | None
"""An individual of a run: the best of a generation, a member, or the best of all."""

Asked = Which | Near
"""An individual of a run as a user asks for it."""


@dataclass(frozen=True, eq=False, repr=False)
class Individual(ReprMixin):
    """An individual of a search, or a gait from a file.

    Attributes:
        experiment: the experiment in force when the individual was evaluated.
        score: its score then; of a gait from a file, the score of its motion.
        terms: the terms of that score by name.
        generation: its generation, counted from 1; of a member, the last one of its search; 0
            for a gait from a file.
        genome: (genes,); None for a gait from a file.
        source: the run's folder or the gait's file; None where nothing is recorded.
        played: the motion of a gait from a file or of a changed body, a population of one.
        member: which member of its search's front or archive it is; None for the best of a
            generation.
        changes: options of the body, by key, that are other than in the run.
    """

    experiment: Experiment
    score: float
    terms: Mapping[str, float]
    generation: int = 0
    genome: NDArray[Any] | None = None
    source: Path | None = None
    played: Motion | None = None
    member: Member | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of_motion(
        cls, experiment: Experiment, motion: Motion, source: Path | None = None
    ) -> "Individual":
        """Score a motion, a population of one, that no genome made.

        Raises:
            PluginError: the fitness cannot evaluate it.
        """
        evaluation = evaluate_motion(experiment, motion, 1)
        score = float(evaluation.scores[0])  # −inf of a motion that failed
        return cls(experiment, score, evaluation.terms_of(0), source=source, played=motion)

    @property
    def title(self) -> str:
        """Where it comes from and how its body is changed, in words."""
        if not self.generation:
            return f"{self.source} on the {self.experiment.entries['organism'].name}{self._changed}"
        best = f"best of generation {self.generation}{self._changed}"
        return f"{self.source or self.experiment.name}, {best if self.best_of else self.label}"

    @property
    def label(self) -> str:
        """Which one of its run it is, such as 'generation 12' or 'member 3 of generation 12'."""
        generation = f"generation {self.generation}{self._changed}"
        return generation if self.member is None else f"{self.member} of {generation}"

    @property
    def stem(self) -> str:
        """Its part of a file's name, such as 'generation-12' or 'generation-12-member-3'."""
        member = "" if self.member is None else f"-member-{self.member.number}"
        changes = "".join(c if c.isalnum() or c in "-." else "-" for c in self._changed[1:])
        return f"generation-{self.generation}{member}{changes[:100]}"

    @property
    def damage(self) -> tuple[str, ...]:
        """The damage to its body, such as 'L2 lost', by the option `damage` of the body."""
        return tuple(map(str, getattr(self.experiment.organism, "damage", ())))

    @property
    def world(self) -> World:
        """The conditions of the world that its body is in by name, by the option `world`."""
        return dict(getattr(self.experiment.organism, WORLD, {}))

    @property
    def _changed(self) -> str:
        """Damage, conditions of the world and what else was changed, each after a comma."""
        other = (
            f"{key.removeprefix('organism.')} {brief(value)}"
            for key, value in self.changes.items()
            if key not in ("organism.damage", f"organism.{WORLD}")
        )
        words = (*self.damage, describe(self.world), *other)
        return "".join(f", {one}" for one in words if one)

    @property
    def best_of(self) -> int | None:
        """The generation of which it is the best; None for a member, or a gait from a file."""
        return self.generation or None if self.member is None else None

    @property
    def name(self) -> str:
        """The name of the run's folder; of what is not recorded, the experiment's."""
        return self.source.resolve().name if self.source else self.experiment.name

    @cached_property
    def motion(self) -> Motion:
        """Its motion, a population of one: channels by name, (1, frames, …) each.

        Raises:
            PluginError: the body cannot move it.
        """
        if self.played is not None:
            return self.played
        if self.genome is None:
            raise ValueError("an individual has a genome or a motion")
        with plugin_errors(self.experiment.entries["organism"], "moving the champion"):
            return self.experiment.organism.move(self.genome[None].copy())

    @cached_property
    def skeleton(self) -> Skeleton:
        """Its body over time, as line segments in metres.

        Raises:
            PluginError: the body cannot be drawn.
        """
        entry, motion = self.experiment.entries["organism"], self.motion
        with plugin_errors(entry, "drawing the champion"):
            skeleton: object = self.experiment.organism.skeleton(motion, 0)
        if isinstance(skeleton, Skeleton):
            return skeleton
        raise contract_error(
            entry,
            f"gave a {type(skeleton).__name__} from skeleton()",
            "a gaitsim.contracts.Skeleton",
        )

    @cached_property
    def measurements(self) -> dict[str, Measurement]:
        """The body's measures of its motion by name, with units.

        Raises:
            PluginError: the body cannot measure it.
        """
        motion = self.motion
        with plugin_errors(self.experiment.entries["organism"], "measuring the champion"):
            return {
                str(name): Measurement(float(measure.values[0]), str(measure.unit), measure.help)
                for name, measure in self.experiment.organism.measures(motion).items()
            }

    @property
    def measures(self) -> dict[str, float]:
        """The values of `measurements`, such as metres walked forward, by name.

        Raises:
            PluginError: the body cannot measure it.
        """
        return {name: measurement.value for name, measurement in self.measurements.items()}

    def unit_of(self, name: str) -> str:
        """Return the unit of one of its measures, of a term, or of the score, by name.

        Raises:
            PluginError: the body cannot measure it.
        """
        measured = self.measurements.get(name)
        return measured.unit if measured else self.experiment.fitness.unit

    @property
    def worlds(self) -> int:
        """How many worlds its recorded score is over; 0 for the world of its motion alone."""
        return self.experiment.worlds.number

    @property
    def over_worlds(self) -> str:
        """' over 4 worlds', to stand after its score; '' for the world of its motion alone."""
        return f" over {self.worlds} world{'s' * (self.worlds != 1)}" if self.worlds else ""

    @property
    def scored_terms(self) -> Mapping[str, float]:
        """The recorded terms of a score over worlds or by Python code that is missing here.

        Else `replayed_terms`.

        Raises:
            PluginError: the body or the fitness fails.
        """
        missing = isinstance(self.experiment.fitness, MissingFitness) and not self.changes
        return self.terms if self.worlds or missing else self.replayed_terms

    def evaluated_terms(self) -> Mapping[str, float]:
        """Return the terms that its genome has in the worlds of its generation.

        Raises:
            PluginError: the body or the fitness fails.
        """
        if self.genome is None or not self.worlds:
            return self.replayed_terms
        return evaluate(self.experiment, self.genome[None], self.generation).terms_of(0)

    @property
    def replayed_terms(self) -> dict[str, float]:
        """The terms of its motion as the installed body and fitness give them now.

        The motion is that in the body's own world, even if the recorded score is over several.

        Raises:
            PluginError: the body or the fitness fails.
        """
        return self._replayed.terms_of(0)

    @property
    def replayed_score(self) -> float:
        """The sum of `replayed_terms`; −inf where the motion fails now."""
        return float(self._replayed.scores[0])

    @property
    def replayed_failure(self) -> str:
        """Why the motion fails now, or ''."""
        return self._replayed.reasons.get(0, "")

    @cached_property
    def _replayed(self) -> Evaluation:
        return evaluate_motion(self.experiment, self.motion, 1)

    @property
    def joint_angles(self) -> NDArray[np.float64] | None:
        """(frames, joints), radians; None where the body has none."""
        if "joint_angles" not in self.experiment.organism.channels:
            return None
        return np.asarray(self.motion["joint_angles"][0], dtype=np.float64)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "experiment": self.experiment.name,
            "generation": self.generation or "",
            **({} if self.member is None else {"member": self.member.number}),
            "score": self.score,
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        measured = {
            f"{name}, {one.unit}" if one.unit else name: one.value
            for name, one in self.measurements.items()
        }
        return {**self._repr_fields(), "measures": measured}
