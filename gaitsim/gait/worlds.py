"""A gait in several worlds: unseen ones, the checks of its body, and with and without reflexes."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import SEED, Genomes, check_world
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.worlds import (
    Ranges,
    World,
    conditions_of,
    describe,
    draw_unseen_worlds,
    has_worlds,
    in_world,
    ranges_of,
)
from gaitsim.experiment import WORLD, Experiment, with_overrides
from gaitsim.gait.feet import Floats
from gaitsim.gait.report import frames_before_fall
from gaitsim.gait.sensitivity import Effect, effects
from gaitsim.gait.travel import frames_in
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin

MEASURE, SCORE = "forward", "score"
ORIENTATION, HEADING = "orientation", "commanded_heading"
NEGLIGIBLE = 0.01  # loss below which an effect is omitted, as a share of the nominal result
MOST = 10_000
"""Largest number of unseen worlds."""

REPORTS = 20  # least number of progress reports, unless there are few worlds
HOLDS = 0.75
"""Least share of its nominal result that a gait that holds keeps in each check."""
COURSE = math.radians(20)
"""Largest root mean square of the yaw of a gait that holds its course; a steady turn by 35°."""

# The horn of a servo fits its spline only in steps, so each joint of a built robot has a constant
# error, which turns the robot off its course. Experiments draw such errors from small seeds.
HORN_ERROR, DRAWS, FIRST_SEED = 2.0, 10, 101  # °, standard deviation
HORNS = "joint_offset"
HORN_WORLDS: tuple[World, ...] = tuple(
    {HORNS: HORN_ERROR, SEED: float(FIRST_SEED + draw)} for draw in range(DRAWS)
)
"""The worlds in which a gait is compared with and without its reflexes."""

Report = Callable[[int], object]


@dataclass(frozen=True)
class Outcome:
    """The result of a gait in one world.

    Attributes:
        result: measure `forward`, or the score if the body does not have this measure.
        score: score of the motion; −inf if it failed.
        fell: whether the body fell, or the motion failed.
        failure: reason why the motion failed, or ''.
        yaw: root mean square of the yaw relative to the commanded heading, until a fall, rad; NaN
            if the body has no orientation.
    """

    result: float
    score: float
    fell: bool
    failure: str = ""
    yaw: float = math.nan

    @property
    def strays(self) -> bool:
        """Whether the body turns away from its course by more than `COURSE`."""
        return self.yaw > COURSE

    def to_dict(self) -> dict[str, Any]:
        """Return the values for JSON."""
        return {**asdict(self), "failure": self.failure or None}


@dataclass(frozen=True, eq=False, repr=False)
class WorldResults(ReprMixin):
    """The results of a gait in several worlds.

    Attributes:
        measure: name of the results: `forward`, or `score` if the body does not have this measure.
        unit: unit of the results.
        nominal: outcome in the gait's own world.
        worlds: other worlds, at least one.
        outcomes: outcome in each of them.
    """

    measure: str
    unit: str
    nominal: Outcome
    worlds: tuple[World, ...]
    outcomes: tuple[Outcome, ...]

    @cached_property
    def results(self) -> Floats:
        """The result in each world, (worlds,) float64; higher is better."""
        return np.array([one.result for one in self.outcomes])

    @cached_property
    def fell(self) -> NDArray[np.bool_]:
        """Whether the body fell in each world, (worlds,)."""
        return np.array([one.fell for one in self.outcomes])

    @property
    def falls(self) -> int:
        """The number of worlds in which the body fell."""
        return int(self.fell.sum())

    @property
    def falls_in_words(self) -> str:
        """Number of worlds in which the body falls, such as '3 falls'."""
        return {0: "no falls", 1: "1 fall"}.get(self.falls, f"{self.falls:,} falls")

    @property
    def failures(self) -> tuple[str, ...]:
        """The reasons for failed motions, in the order of the worlds."""
        return tuple(one.failure for one in self.outcomes if one.failure)

    @property
    def mean(self) -> float:
        """Mean result."""
        return sum(one.result for one in self.outcomes) / len(self.outcomes)

    @property
    def yaw(self) -> float:
        """Root mean square of the yaw relative to the commanded heading, over all worlds, rad."""
        return math.sqrt(sum(one.yaw**2 for one in self.outcomes) / len(self.outcomes))

    def kept(self, result: float) -> float:
        """Return a result as a share of the nominal result; NaN if the nominal one is ≤ 0."""
        return result / self.nominal.result if self.nominal.result > 0 else math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics and all worlds as values for JSON."""
        worlds = [
            {"world": dict(world), **outcome.to_dict()}
            for world, outcome in zip(self.worlds, self.outcomes, strict=True)
        ]
        return {**self.statistics(), "worlds": worlds}

    def statistics(self) -> dict[str, Any]:
        """Return the statistics as values for JSON, without the individual worlds."""
        return {
            "measure": self.measure,
            "unit": self.unit,
            "number": len(self.worlds),
            "nominal": self.nominal.to_dict(),
            "mean": self.mean,
            "kept_mean": self.kept(self.mean),
            "yaw": self.yaw,
            "falls": self.falls,
        }

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "worlds": len(self.worlds),
            "measure": self.measure,
            "nominal": self.nominal.result,
            "mean": self.mean,
            "falls": self.falls,
        }


def evaluate_in(
    individual: Individual,
    worlds: Sequence[World],
    *,
    workers: int | None = None,
    begin: Report = lambda total: None,
    advance: Report = lambda worlds: None,
) -> WorldResults:
    """Move a gait in several worlds.

    The result does not depend on the number of workers. A gait from a file is played; a genome
    moves the body. Damage to the body is kept.

    Args:
        individual: individual of a run or from a file.
        worlds: values of conditions by name.
        workers: number of workers; None for a number that suits the body.
        begin: called with the number of worlds.
        advance: called with the number of worlds that were completed since the last call.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract.
    """
    begin(len(worlds))
    experiment = individual.experiment
    measured = individual.measurements.get(MEASURE)
    about = (MEASURE, measured.unit) if measured else (SCORE, experiment.fitness.unit)
    nominal = outcome_of(individual)
    experiment = replace(experiment, worlds=experiment.worlds.own)
    angles = individual.joint_angles if individual.genome is None else None
    work = partial(_outcome_in, individual.genome, angles)
    outcomes: list[Outcome] = []
    with Evaluator(experiment, workers) as evaluator:
        step = evaluator.workers * max(1, len(worlds) // (REPORTS * evaluator.workers))
        for start in range(0, len(worlds), step):
            part = worlds[start : start + step]
            outcomes += evaluator.map(work, part)
            advance(len(part))
    return WorldResults(*about, nominal, tuple(worlds), tuple(outcomes))


def _outcome_in(
    genome: Genomes | None, angles: Floats | None, experiment: Experiment, world: World
) -> Outcome:
    """Move a genome, or play joint angles, (frames, joints), in a world."""
    moved = in_world(experiment, world)
    played = None if angles is None else play(moved, angles[None])
    return outcome_of(Individual(moved, math.nan, {}, genome=genome, played=played))


def outcome_of(individual: Individual) -> Outcome:
    """Return the outcome of an individual in its own world."""
    failure, score = individual.replayed_failure, individual.replayed_score
    measured = individual.measurements.get(MEASURE)
    result = score if measured is None else measured.value
    if measured is not None and (failure or not math.isfinite(result)):
        result = 0.0  # as in adaptation, a motion that failed covers no distance
    fell = bool(failure) or has_fallen(individual)
    return Outcome(result, score, fell, failure, _yaw_of(individual))


def _yaw_of(individual: Individual) -> float:
    motion, channels = individual.motion, individual.body.channels
    if ORIENTATION not in channels:
        return math.nan
    frames = frames_before_fall(individual)
    yaw = motion[ORIENTATION][0, :frames, -1]
    if HEADING in channels:
        yaw = yaw - motion[HEADING][0, :frames]
    return math.sqrt(float(np.mean(np.square(yaw))))


def has_fallen(individual: Individual) -> bool:
    """Return whether the body fell, according to its channel `lasted`, s; False without it."""
    channels, motion = individual.body.channels, individual.motion
    lasted = channels.get("lasted")
    over_time = [name for name, one in channels.items() if one.axes[:1] == ("frames",)]
    if lasted is None or lasted.axes or lasted.unit != "s" or not over_time:
        return False
    frames = np.shape(motion[over_time[0]])[1]
    return bool(frames_in(float(motion["lasted"][0]), motion.frame_rate) < frames)


@dataclass(frozen=True, eq=False, repr=False)
class UnseenResults(WorldResults):
    """The results of a gait in unseen worlds, in which it did not evolve.

    Attributes:
        ranges: range of each condition that varies, by name.
        units: unit of each of these conditions, by name.
        seed: seed of the worlds.
    """

    ranges: Ranges
    units: Mapping[str, str]
    seed: int

    @cached_property
    def conditions(self) -> dict[str, Floats]:
        """The values of each condition by name, (worlds,) each."""
        return {name: np.array([world[name] for world in self.worlds]) for name in self.ranges}

    @property
    def worst_tenth(self) -> float:
        """The mean of the worst tenth of the results, rounded up."""
        return float(np.sort(self.results)[: -(-len(self.results) // 10)].mean())

    def quantile(self, share: float) -> float:
        """Return a quantile of the results, interpolated linearly."""
        if np.isfinite(self.results).all():
            return float(np.quantile(self.results, share))
        return float(np.quantile(self.results, share, method="lower"))  # cannot interpolate −inf

    @property
    def median(self) -> float:
        """The median of the results."""
        return self.quantile(0.5)

    @property
    def worst(self) -> World:
        """The world with the lowest result."""
        return self.worlds[int(np.argmin(self.results))]

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The conditions with a significant and relevant effect, the strongest first."""
        found = effects(self.conditions, self.ranges, self.results)
        least = NEGLIGIBLE * abs(self.nominal.result)
        return tuple(one for one in found if not one.loss < least)

    def statistics(self) -> dict[str, Any]:
        return {
            **super().statistics(),
            "seed": self.seed,
            "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            "worst_tenth": self.worst_tenth,
            "worst": self.quantile(0),
            "q25": self.quantile(0.25),
            "median": self.median,
            "q75": self.quantile(0.75),
            "best": self.quantile(1),
            "kept_worst_tenth": self.kept(self.worst_tenth),
            "kept_median": self.kept(self.median),
            "effects": [asdict(one) for one in self.effects],
        }

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "worlds": len(self.worlds),
            "measure": self.measure,
            "nominal": self.nominal.result,
            "median": self.median,
            "worst_tenth": self.worst_tenth,
            "falls": self.falls,
            "losses": {one.condition: one.loss for one in self.effects},
        }


def evaluate_unseen(
    individual: Individual,
    number: int = 100,
    *,
    seed: int = 0,
    ranges: Ranges | None = None,
    workers: int | None = None,
    begin: Report = lambda total: None,
    advance: Report = lambda worlds: None,
) -> UnseenResults:
    """Test a gait in unseen worlds; see `evaluate_in`.

    Args:
        individual: individual of a run or from a file.
        number: number of worlds, from 1 to `MOST`.
        seed: seed of the worlds. With the same seed and ranges, all gaits meet the same worlds.
        ranges: range of each condition that varies, by name. None takes the ranges of the
            experiment's worlds or, if it has none, the usual ranges of all conditions of the body,
            without the conditions to which the individual's changes give a fixed value.
        workers: number of workers; None for a number that suits the body.
        begin: called with the number of worlds.
        advance: called with the number of worlds that were completed since the last call.

    Raises:
        GaitsimError: the body has no conditions, the number or the seed is invalid, or the motion
            fails in every world.
        PluginError: the body or the fitness fails or breaks its contract.
    """
    check_request(number, seed)
    experiment = individual.experiment
    conditions = conditions_of(experiment)
    chosen = _varying_ranges(individual) if ranges is None else _check_ranges(experiment, ranges)
    worlds = draw_unseen_worlds(experiment, number, chosen, seed)
    found = evaluate_in(individual, worlds, workers=workers, begin=begin, advance=advance)
    if len(found.failures) == number:
        raise GaitsimError(
            f"the motion fails in each of {number:,} worlds: {found.failures[0]}",
            where=individual.title,
            remedy="test another gait, or narrow the ranges of the conditions",
        )
    units = {name: one.unit for name, one in conditions.items() if name in chosen}
    return UnseenResults(**vars(found), ranges=chosen, units=units, seed=int(seed))


def check_request(number: object, seed: object) -> None:
    """Check a number of worlds and their seed."""
    for value, what, least, most in (
        (number, "number of worlds", 1, MOST),
        (seed, "seed of worlds", 0, 2**53 - 1),
    ):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not (whole and least <= value <= most):  # type: ignore[operator]
            raise GaitsimError(
                f"invalid {what}: {value!r}", allowed=f"a whole number from {least} to {most:,}"
            )


def _varying_ranges(individual: Individual) -> Ranges:
    fixed = individual.changes.get(f"organism.{WORLD}", {})
    ranges = ranges_of(individual.experiment)
    varying = {name: ends for name, ends in ranges.items() if name not in fixed}
    if not varying:
        raise GaitsimError(
            "every condition that varies between worlds has a fixed value",
            where=describe(fixed),
            allowed=f"at least one of {', '.join(ranges)} without a fixed value",
        )
    return varying


def _check_ranges(experiment: Experiment, ranges: Ranges) -> Ranges:
    lists = {name: [*ends] for name, ends in ranges.items()}
    return ranges_of(with_overrides(experiment, {"worlds.ranges": lists}))


@dataclass(frozen=True, eq=False, repr=False)
class CheckResults(WorldResults):
    """The results of a gait in the worlds in which its body says that a good gait still works.

    Attributes:
        varied: descriptions of the conditions of each world, such as 'friction of the feet'.
    """

    varied: tuple[str, ...]

    @cached_property
    def passed(self) -> tuple[bool, ...]:
        """Whether the body stays upright, on course, and keeps `HOLDS` of its result, by world."""
        return tuple(
            not one.fell and not one.strays and self.kept_in(at) >= HOLDS
            for at, one in enumerate(self.outcomes)
        )

    @property
    def holds(self) -> bool:
        """Whether the gait passes all checks, and stays upright and on course in its own world."""
        return all(self.passed) and not self.nominal.fell and not self.nominal.strays

    @property
    def worst(self) -> int:
        """Index of the world in which the gait keeps least, of those with falls or other faults."""
        return min(
            range(len(self.worlds)),
            key=lambda at: (not self.outcomes[at].fell, self.passed[at], self.kept_in(at)),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The conditions of the failed checks, such as 'friction of the feet on the ground'."""
        failed = (one for one, passed in zip(self.varied, self.passed, strict=True) if not passed)
        return tuple(dict.fromkeys(filter(None, failed)))

    def kept_in(self, at: int) -> float:
        """Return the share of the nominal result that the gait keeps in a world; 0 if it fails."""
        result = self.outcomes[at].result
        return self.kept(result if math.isfinite(result) else 0.0)

    @property
    def summary(self) -> str:
        """Return the results on one line, such as 'Holds: keeps 86 % of 4.40 m in …'."""
        if not self.nominal.result > 0:
            return "Not checked in other worlds, as the gait does not move forward in its own."
        if self.nominal.fell:
            return "Does not hold: falls in its own world."
        if self.nominal.strays:
            turn = math.degrees(self.nominal.yaw)
            return f"Does not hold its course: its yaw is {turn:.0f}° (RMS) in its own world."
        total, worst = f"{self.nominal.result:.2f} {self.unit}".rstrip(), self.worst
        world, count = describe(self.worlds[worst]), f"{len(self.worlds)} checks"
        kept = f"keeps {100 * self.kept_in(worst):.0f} % of {total}"
        if self.holds:
            return f"Holds: {kept} in the worst of {count} ({world})."
        end = self.outcomes[worst]
        strays = f" and turns by {math.degrees(end.yaw):.0f}° (RMS)" if end.strays else ""
        falls = " and falls" if end.fell else strays
        failed = self.passed.count(False)
        return f"Does not hold: {kept}{falls} at {world}; fails {failed} of {count}."

    def to_dict(self) -> dict[str, Any]:
        found = super().to_dict()
        for at, one in enumerate(found["worlds"]):
            one |= {"kept": self.kept_in(at), "passed": self.passed[at]}
        return {**found, "holds": self.holds, "depends_on": list(self.depends_on)}

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "holds": self.holds,
            "measure": self.measure,
            "nominal": self.nominal.result,
            "kept": {describe(one): self.kept_in(at) for at, one in enumerate(self.worlds)},
        }


def check_worlds_of(experiment: Experiment) -> tuple[World, ...]:
    """Return the worlds that a body names as checks.

    Raises:
        PluginError: the body fails, or names a world that it does not have.
    """
    entry, body = experiment.entries["organism"], experiment.organism
    with plugin_errors(entry, "naming its checks"):
        worlds = tuple(body.checks())
        conditions = body.conditions() if worlds and has_worlds(experiment) else {}
        for world in worlds:
            try:
                check_world(world, conditions)
            except GaitsimError as error:
                what = f"names an invalid check: {error.what}"
                raise contract_error(entry, what, error.allowed) from None
    return worlds


def check_gait(
    individual: Individual,
    *,
    workers: int | None = None,
    begin: Report = lambda total: None,
    advance: Report = lambda worlds: None,
) -> CheckResults | None:
    """Move a gait in the worlds that its body names as checks; see `evaluate_in`.

    Returns:
        None for a body that names no such worlds.
    """
    worlds = check_worlds_of(individual.experiment)
    if not worlds:
        return None
    known = conditions_of(individual.experiment)
    found = evaluate_in(individual, worlds, workers=workers, begin=begin, advance=advance)
    varied = (", ".join(known[name].help for name in world if name in known) for world in worlds)
    return CheckResults(**vars(found), varied=tuple(varied))


@dataclass(frozen=True, repr=False)
class FeedbackResults(ReprMixin):
    """A gait under errors of its servo horns, with and without its reflexes.

    Attributes:
        reflexes: names of the reflexes.
        feeling: results with reflexes.
        blind: results without reflexes.
    """

    reflexes: tuple[str, ...]
    feeling: WorldResults
    blind: WorldResults

    def to_dict(self) -> dict[str, Any]:
        """Return the results as values for JSON."""
        return {
            "reflexes": list(self.reflexes),
            "feeling": self.feeling.to_dict(),
            "blind": self.blind.to_dict(),
        }

    def _repr_fields(self) -> Mapping[str, ReprField]:
        fields: dict[str, ReprField] = {}
        for name, one in (("feeling", self.feeling), ("blind", self.blind)):
            values = one.yaw, one.kept(one.mean), one.falls
            fields |= {
                f"{name}_{key}": value
                for key, value in zip(("yaw", "kept", "falls"), values, strict=True)
            }
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
    if HORNS not in conditions_of(experiment):
        return None
    changed = replace(experiment, organism=found[0])
    return replace(individual, experiment=changed, genome=found[1][0], played=None)


def compare_blind(
    individual: Individual,
    *,
    workers: int | None = None,
    begin: Report = lambda total: None,
    advance: Report = lambda worlds: None,
) -> FeedbackResults | None:
    """Move a gait with and without its reflexes, with `DRAWS` draws of errors of its horns.

    `evaluate_in` describes the arguments.

    Returns:
        None for a body without reflexes, and for a gait from a file.
    """
    blind = blinded(individual)
    if blind is None:
        return None
    begin(2 * len(HORN_WORLDS))
    feeling, without = (
        evaluate_in(one, HORN_WORLDS, workers=workers, advance=advance)
        for one in (individual, blind)
    )
    experiment = individual.experiment
    with plugin_errors(experiment.entries["organism"], "naming its reflexes"):
        reflexes = tuple(experiment.organism.reflex_names())
    return FeedbackResults(reflexes, feeling, without)
