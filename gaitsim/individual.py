"""Individuals: genomes with their scores, and the motion of their bodies."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion, Organism, RealSpace, Skeleton
from gaitsim.evaluation.scoring import Evaluation, evaluate, evaluate_motion
from gaitsim.evaluation.worlds import World, describe
from gaitsim.evolution import Generation
from gaitsim.experiment import WORLD, Experiment
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.registry.python_plugins import MissingFitness
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.toml import brief, shortened


class Measurement(NamedTuple):
    """One measure of a motion: its value, unit and meaning."""

    value: float
    unit: str
    help: str


@dataclass(frozen=True)
class Member:
    """A member of a search's front or archive, identified by its number, counted from 1."""

    number: int

    def __str__(self) -> str:
        return f"member {self.number}"


@dataclass(frozen=True)
class Numbered:
    """Any individual of a run, identified by generation and number in it, counted from 1.

    The number 0 is the centre of the generation, around which it was drawn.
    """

    generation: int
    number: int

    def __str__(self) -> str:
        if not self.number:
            return f"the centre of generation {self.generation}"
        return f"individual {self.number} of generation {self.generation}"


Which = int | Member | Numbered | None
"""An individual of a run: the best of a generation, a member, any other, or the best of the run."""


CENTRE = "centre"
"""The number of the centre of a generation, as users type it."""


def mark_of(which: Which) -> str:
    """Return what names an individual after its run: '@12', '@12:34', '#3', or '' for the best."""
    match which:
        case None:
            return ""
        case Member():
            return f"#{which.number}"
        case Numbered():
            return f"@{which.generation}:{which.number or CENTRE}"
    return f"@{which}"


def parse_mark(text: str) -> int | Numbered:
    """Return the generation in a text such as '12', or the individual in one such as '12:34'."""
    generation, _, number = text.partition(":")
    if not number:
        return int(generation)
    return Numbered(int(generation), 0 if number == CENTRE else int(number))


Choice = Which | Mapping[str, float]
"""An individual of a run, as chosen by a user: also the best member near values, by axis."""


@dataclass(frozen=True, eq=False, repr=False)
class Individual(ReprMixin):
    """An individual of a search, or a gait from a file.

    Attributes:
        experiment: experiment with which the individual was evaluated.
        score: score in that evaluation; for a gait from a file, the score of its motion.
        terms: terms of the score by name.
        generation: generation of the individual, counted from 1; for a member, the last generation
            of the search; 0 for a gait from a file.
        genome: genome, (genes,); None for a gait from a file.
        source: folder of the run or file of the gait; None if not recorded.
        played: motion of a gait from a file or of a changed body, a population of one.
        member: member of the front or archive, or number in its generation; None for the best of
            a generation.
        changes: options of the body that differ from the run, by key.
        note: what films and pages say about it besides its label; '' for nothing.
    """

    experiment: Experiment
    score: float
    terms: Mapping[str, float]
    generation: int = 0
    genome: NDArray[Any] | None = None
    source: Path | None = None
    played: Motion | None = None
    member: Member | Numbered | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    note: str = ""

    @classmethod
    def of_motion(
        cls, experiment: Experiment, motion: Motion, source: Path | None = None
    ) -> "Individual":
        """Return an individual without a genome from its motion, a population of one.

        Raises:
            PluginError: the fitness cannot evaluate it.
        """
        evaluation = evaluate_motion(experiment, motion, 1)
        score = float(evaluation.scores[0])  # −inf if the motion failed
        return cls(experiment, score, evaluation.terms_of(0), source=source, played=motion)

    @classmethod
    def of_generation(
        cls, experiment: Experiment, generation: Generation, index: int, source: Path | None = None
    ) -> Self:
        """Return an individual of a generation by its index in the population, from 0."""
        score, terms = float(generation.scores[index]), generation.evaluation.terms_of(index)
        genome = generation.genomes[index]
        return cls(experiment, score, terms, generation.number, genome, source)

    @property
    def title(self) -> str:
        """A description of where the individual comes from and how its body was changed."""
        if not self.generation:
            body = self.experiment.entries["organism"].name
            return f"{self.source} on the {body}{self._changes_text}"
        best = f"best of generation {self.generation}{self._changes_text}"
        note = f" ({self.note})" if self.note else ""
        label = best if self.best_of else self.label
        return f"{self.source or self.experiment.name}, {label}{note}"

    @property
    def label(self) -> str:
        """The name of the individual within its run, such as 'member 3 of generation 12'."""
        if isinstance(self.member, Numbered):
            return f"generation {mark_of(self.member)[1:]}{self._changes_text}"
        generation = f"generation {self.generation}{self._changes_text}"
        return generation if self.member is None else f"{self.member} of {generation}"

    @property
    def stem(self) -> str:
        """The part of a file name for the individual, such as 'generation-12-member-3'."""
        kind = "individual" if isinstance(self.member, Numbered) else "member"
        member = "" if self.member is None else f"-{kind}-{self.member.number}"
        changes = "".join(c if c.isalnum() or c in "-." else "-" for c in self._changes_text[1:])
        return f"generation-{self.generation}{member}{changes[:100]}"

    @property
    def damage(self) -> tuple[str, ...]:
        """The damage to the body, such as 'L2 lost', from its option `damage`."""
        return tuple(map(str, getattr(self.experiment.organism, "damage", ())))

    @property
    def world(self) -> World:
        """The conditions of the body's world by name, from its option `world`."""
        return dict(getattr(self.experiment.organism, WORLD, {}))

    @property
    def _changes_text(self) -> str:
        """Damage, conditions of the world and other changes, each preceded by a comma."""
        other = (
            f"{key.removeprefix('organism.')} {shortened(brief(value))}"
            for key, value in self.changes.items()
            if key not in ("organism.damage", f"organism.{WORLD}")
        )
        words = (*self.damage, describe(self.world), *other)
        return "".join(f", {one}" for one in words if one)

    @property
    def best_of(self) -> int | None:
        """The generation whose best individual this is; None for a member or a gait from a file."""
        return self.generation or None if self.member is None else None

    @property
    def name(self) -> str:
        """The name of the run's folder, or of the experiment if nothing is recorded."""
        return self.source.resolve().name if self.source else self.experiment.name

    @cached_property
    def embodied(self) -> "Individual":
        """The individual on a body with its own dimensions, whose genome has no genes of them.

        It is the individual itself if its dimensions are not genes; see `Organism.embody`.

        Raises:
            PluginError: the body fails.
        """
        if self.genome is None:
            return self
        with plugin_errors(self.experiment.entries["organism"], "building the champion's body"):
            body, genes = self.experiment.organism.embody(self.genome.copy())
        if body is self.experiment.organism:
            return self
        return replace(self, experiment=replace(self.experiment, organism=body), genome=genes)

    @property
    def body(self) -> Organism:
        """The body of the individual, with its own dimensions."""
        return self.embodied.experiment.organism

    @cached_property
    def motion(self) -> Motion:
        """The motion of its own body, a population of one: channels by name, each (1, frames, …).

        Raises:
            PluginError: the body fails.
        """
        if self.played is not None:
            motion = self.played
        elif self.genome is None:
            raise ValueError("an individual needs a genome or a motion")
        else:
            genome = self.embodied.genome
            assert genome is not None, "it has the rest of the genes"
            with plugin_errors(self.experiment.entries["organism"], "moving the champion"):
                motion = self.body.move(genome[None].copy())
        if isinstance(motion, Motion):  # otherwise, its user reports the mistake of the plugin
            motion.declared = self.body.channels
        return motion

    @cached_property
    def skeleton(self) -> Skeleton:
        """The body over time, as line segments in metres.

        Raises:
            PluginError: the body cannot be drawn.
        """
        entry, motion = self.experiment.entries["organism"], self.motion
        with plugin_errors(entry, "drawing the champion"):
            skeleton: object = self.body.skeleton(motion, 0)
        if isinstance(skeleton, Skeleton):
            return skeleton
        raise contract_error(
            entry,
            f"returned a {type(skeleton).__name__} from skeleton()",
            "a gaitsim.contracts.Skeleton",
        )

    @property
    def stance(self) -> NDArray[np.bool_] | None:
        """Whether each foot is on the ground until the next frame, (frames, feet).

        The channel `stance` of the body takes precedence over its skeleton, which shows the feet
        that touch the ground in a picture. None for a body without feet.

        Raises:
            PluginError: the body fails.
        """
        touching = self.skeleton.touching
        channel = self.body.channels.get("stance")
        if touching is None or channel is None or channel.axes != ("frames", "feet"):
            return touching
        with plugin_errors(self.experiment.entries["organism"], "computing the channel 'stance'"):
            stance = np.asarray(self.motion["stance"][0], np.bool_)
        return stance if stance.shape == touching.shape else touching

    @cached_property
    def measurements(self) -> dict[str, Measurement]:
        """The body's measures of the motion by name, with units.

        Raises:
            PluginError: the body cannot measure the motion.
        """
        motion = self.motion
        with plugin_errors(self.experiment.entries["organism"], "measuring the champion"):
            return {
                str(name): Measurement(float(measure.values[0]), str(measure.unit), measure.help)
                for name, measure in self.body.measures(motion).items()
            }

    @property
    def measures(self) -> dict[str, float]:
        """The values of `measurements`, such as metres walked forward, by name.

        Raises:
            PluginError: the body cannot measure the motion.
        """
        return {name: measurement.value for name, measurement in self.measurements.items()}

    def unit_of(self, name: str) -> str:
        """Return the unit of a measure, a term or the score by name; '' for other values.

        Raises:
            PluginError: the body cannot measure the motion.
        """
        measured = self.measurements.get(name)
        if measured:
            return measured.unit
        scored = name == "score" or name.removeprefix("term:") in self.terms
        return self.experiment.fitness.unit if scored else ""

    @property
    def worlds(self) -> int:
        """The number of worlds that the recorded score combines; 0 for the body's own world."""
        return self.experiment.worlds.count

    @property
    def over_worlds(self) -> str:
        """A suffix for the score, such as ' over 4 worlds'; '' for the body's own world."""
        return f" over {self.worlds} world{'s' * (self.worlds != 1)}" if self.worlds else ""

    @property
    def scored_terms(self) -> Mapping[str, float]:
        """The terms of the score.

        These are the recorded terms if the score is over several worlds or computed by Python code
        that is missing here, and `replayed_terms` otherwise.

        Raises:
            PluginError: the body or the fitness fails.
        """
        missing = isinstance(self.experiment.fitness, MissingFitness) and not self.changes
        return self.terms if self.worlds or missing else self.replayed_terms

    def evaluated_terms(self) -> Mapping[str, float]:
        """Return the terms of the genome evaluated in the worlds of its generation.

        Raises:
            PluginError: the body or the fitness fails.
        """
        if self.genome is None or not self.worlds:
            return self.replayed_terms
        return evaluate(self.experiment, self.genome[None], self.generation).terms_of(0)

    @property
    def replayed_terms(self) -> dict[str, float]:
        """The terms of the motion, computed by the installed body and fitness.

        The motion is in the body's own world, even if the recorded score is over several worlds.

        Raises:
            PluginError: the body or the fitness fails.
        """
        return self._replayed.terms_of(0)

    @property
    def replayed_score(self) -> float:
        """The sum of `replayed_terms`; −inf if the motion fails."""
        return float(self._replayed.scores[0])

    @property
    def replayed_failure(self) -> str:
        """The reason why the motion fails, or ''."""
        return self._replayed.reasons.get(0, "")

    @cached_property
    def _replayed(self) -> Evaluation:
        return evaluate_motion(self.experiment, self.motion, 1)

    @property
    def joint_angles(self) -> NDArray[np.float64] | None:
        """The joint angles, (frames, joints), radians; None for a body without them."""
        if "joint_angles" not in self.experiment.organism.channels:
            return None
        return np.asarray(self.motion["joint_angles"][0], dtype=np.float64)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "experiment": self.experiment.name,
            "generation": self.generation or "",
            **({} if self.member is None else {"member": self.member.number}),
            "score": self.score,
            "changes": self._changes_text.removeprefix(", "),
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        measured = {
            f"{name}, {one.unit}" if one.unit else name: one.value
            for name, one in self.measurements.items()
        }
        return {**self._repr_fields(), "measures": measured}


def standing_skeleton(experiment: Experiment) -> Skeleton:
    """Return the skeleton for the central genome, whose motion starts in the standing pose."""
    space = experiment.space()
    middle = (
        (space.lower + space.upper) / 2
        if isinstance(space, RealSpace)
        else space.random(1, np.random.default_rng(0))[0]
    )
    return Individual(experiment, 0.0, {}, genome=middle).skeleton
