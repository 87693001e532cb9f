"""The worth of reflexes: the same gait with and without them, under errors of servo horns.

The horn of a servo fits its spline only in steps, so that each joint of a built robot has a
constant error, which turns the robot off its course.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from gaitsim.contracts import SEED
from gaitsim.evaluation.worlds import World, conditions_of, has_worlds
from gaitsim.gait.report import frames_before_fall
from gaitsim.gait.unseen import MEASURE, evaluate_in, has_fallen
from gaitsim.individual import Individual
from gaitsim.registry import plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin

CONDITION, ERROR = "joint_offset", 2.0  # °, standard deviation of the errors
DRAWS = 10
FIRST_SEED = 101  # experiments that evolve with errors draw them from small seeds
WORLDS: tuple[World, ...] = tuple(
    {CONDITION: ERROR, SEED: float(FIRST_SEED + draw)} for draw in range(DRAWS)
)
"""The worlds in which gaits are compared."""
REPORTED = 2 * DRAWS  # worlds of both gaits
ORIENTATION, HEADING = "orientation", "commanded_heading"


@dataclass(frozen=True)
class Course:
    """How far and how straight a gait walked.

    Attributes:
        forward: distance forward, m.
        yaw: root mean square of the yaw relative to the commanded heading, until a fall, rad.
        fell: whether the body fell, or the motion failed.
    """

    forward: float
    yaw: float
    fell: bool


@dataclass(frozen=True)
class Walks:
    """The courses of one gait.

    Attributes:
        nominal: course without errors.
        draws: course with each draw of the errors.
    """

    nominal: Course
    draws: tuple[Course, ...]

    @property
    def yaw(self) -> float:
        """Root mean square of the yaw relative to the commanded heading, over all draws, rad."""
        return math.sqrt(sum(one.yaw**2 for one in self.draws) / len(self.draws))

    @property
    def kept(self) -> float:
        """Mean distance as a share of the nominal one; NaN if the gait does not go forward."""
        if not self.nominal.forward > 0:
            return math.nan
        return sum(one.forward for one in self.draws) / len(self.draws) / self.nominal.forward

    @property
    def falls(self) -> int:
        """Number of draws in which the body fell."""
        return sum(one.fell for one in self.draws)

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics and courses as values for JSON."""
        found = {"yaw": self.yaw, "kept": self.kept, "falls": self.falls}
        return {**found, **asdict(self)}


@dataclass(frozen=True, repr=False)
class FeedbackResults(ReprMixin):
    """A gait under errors of its servo horns, with and without its reflexes.

    Attributes:
        reflexes: names of the reflexes.
        feeling: courses with reflexes.
        blind: courses without reflexes.
    """

    reflexes: tuple[str, ...]
    feeling: Walks
    blind: Walks

    def to_dict(self) -> dict[str, Any]:
        """Return the results as values for JSON."""
        return {
            "reflexes": list(self.reflexes),
            "worlds": [dict(world) for world in WORLDS],
            "feeling": self.feeling.to_dict(),
            "blind": self.blind.to_dict(),
        }

    def _repr_fields(self) -> Mapping[str, ReprField]:
        both = {"feeling": self.feeling, "blind": self.blind}
        fields: dict[str, ReprField] = {}
        for name, walks in both.items():
            fields[f"{name}_yaw"] = walks.yaw
            fields[f"{name}_kept"] = walks.kept
            fields[f"{name}_falls"] = walks.falls
        return fields


def blinded(individual: Individual) -> Individual | None:
    """Return an individual without its reflexes.

    Returns:
        None if the body has no reflexes, or if errors of its horns or its yaw are not simulated.

    Raises:
        PluginError: the body fails.
    """
    experiment, genome = individual.experiment, individual.genome
    body = experiment.organism
    if genome is None or not has_worlds(experiment):
        return None
    with plugin_errors(experiment.entries["organism"], "removing its reflexes"):
        found = body.blind(genome[None].copy())
    if found is None or ORIENTATION not in body.channels:
        return None
    if CONDITION not in conditions_of(experiment):
        return None
    organism, genomes = found
    return replace(
        individual,
        experiment=replace(experiment, organism=organism),
        genome=genomes[0],
        played=None,
    )


def compare_blind(
    individual: Individual,
    *,
    workers: int | None = None,
    advance: Callable[[int], object] = lambda worlds: None,
) -> FeedbackResults | None:
    """Move a gait with and without its reflexes, with `DRAWS` draws of errors of its horns.

    Args:
        individual: individual of a run.
        workers: number of workers; None for a number that suits the body.
        advance: called with the number of worlds that were completed since the last call, of
            `REPORTED`.

    Returns:
        None for a body without reflexes, and for a gait from a file.

    Raises:
        PluginError: the body fails or breaks its contract.
    """
    blind = blinded(individual)
    if blind is None:
        return None
    feeling, without = (
        Walks(course_of(one), evaluate_in(one, WORLDS, workers, advance, course_of))
        for one in (individual, blind)
    )
    experiment = individual.experiment
    with plugin_errors(experiment.entries["organism"], "naming its reflexes"):
        reflexes = tuple(experiment.organism.reflex_names())
    return FeedbackResults(reflexes, feeling, without)


def course_of(individual: Individual) -> Course:
    """Return how far and how straight an individual walks; its fitness is not needed."""
    motion, channels = individual.motion, individual.experiment.organism.channels
    frames = frames_before_fall(individual)
    yaw = motion[ORIENTATION][0, :frames, -1]
    if HEADING in channels:
        yaw = yaw - motion[HEADING][0, :frames]
    forward = individual.measures.get(MEASURE, math.nan)
    return Course(
        forward if math.isfinite(forward) else 0.0,
        math.sqrt(float(np.mean(np.square(yaw)))),
        bool(motion.failures) or has_fallen(individual),
    )
