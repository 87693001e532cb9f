"""Test a gait in unseen worlds, in which it did not evolve; the results in several worlds."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.worlds import (
    Ranges,
    World,
    conditions_of,
    describe,
    draw_unseen_worlds,
    in_world,
    ranges_of,
)
from gaitsim.experiment import WORLD, Experiment, with_overrides
from gaitsim.gait.feet import Floats
from gaitsim.gait.sensitivity import Effect, effects
from gaitsim.gait.travel import frames_in
from gaitsim.individual import Individual
from gaitsim.repr_mixin import ReprField, ReprMixin

Result = TypeVar("Result")

MEASURE, SCORE = "forward", "score"
NEGLIGIBLE = 0.01  # loss below which an effect is omitted, as a share of the nominal result


@dataclass(frozen=True)
class Outcome:
    """The result of a gait in one world.

    Attributes:
        result: measure `forward`, or the score if the body does not have this measure.
        score: score of the motion; −inf if it failed.
        fell: whether the body fell, or the motion failed.
        failure: reason why the motion failed, or ''.
    """

    result: float
    score: float
    fell: bool
    failure: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the values for JSON."""
        return {**asdict(self), "failure": self.failure or None}


@dataclass(frozen=True, eq=False, repr=False)
class UnseenResults(ReprMixin):
    """The results of a gait in unseen worlds.

    Attributes:
        measure: name of the results: `forward`, or `score` if the body does not have this measure.
        unit: unit of the results.
        nominal: outcome in the gait's own world.
        ranges: range of each condition that varies, by name.
        units: unit of each of these conditions, by name.
        seed: seed of the worlds.
        worlds: unseen worlds.
        outcomes: outcome in each world.
    """

    measure: str
    unit: str
    nominal: Outcome
    ranges: Ranges
    units: Mapping[str, str]
    seed: int
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

    @cached_property
    def conditions(self) -> dict[str, Floats]:
        """The values of each condition by name, (worlds,) each."""
        return {name: np.array([world[name] for world in self.worlds]) for name in self.ranges}

    @property
    def worst_tenth(self) -> float:
        """The mean of the worst tenth of the results, or of the worst one if there are few."""
        return float(worst_tenth(self.results))

    def quantile(self, share: float) -> float:
        """Return a quantile of the results, interpolated linearly."""
        if np.isfinite(self.results).all():
            return float(np.quantile(self.results, share))
        return float(np.quantile(self.results, share, method="lower"))  # cannot interpolate −inf

    @property
    def median(self) -> float:
        """The median of the results."""
        return self.quantile(0.5)

    def kept(self, result: float) -> float:
        """Return a result as a share of the nominal result; NaN if the nominal one is ≤ 0."""
        return result / self.nominal.result if self.nominal.result > 0 else math.nan

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The conditions with a significant and relevant effect, the strongest first."""
        found = effects(self.conditions, self.ranges, self.results)
        least = NEGLIGIBLE * abs(self.nominal.result)
        return tuple(one for one in found if not one.loss < least)

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

    @property
    def worst(self) -> World:
        """The world with the lowest result."""
        return self.worlds[int(np.argmin(self.results))]

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
            "seed": self.seed,
            "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            "nominal": self.nominal.to_dict(),
            "worst_tenth": self.worst_tenth,
            "worst": self.quantile(0),
            "q25": self.quantile(0.25),
            "median": self.median,
            "q75": self.quantile(0.75),
            "best": self.quantile(1),
            "kept_worst_tenth": self.kept(self.worst_tenth),
            "kept_median": self.kept(self.median),
            "falls": self.falls,
            "effects": [asdict(one) for one in self.effects],
        }


def worst_tenth(results: Floats) -> Floats:
    """Return the mean of the worst tenth, rounded up, of results, (…, worlds), in shape (…)."""
    counted = -(-results.shape[-1] // 10)
    return np.asarray(np.sort(results, axis=-1)[..., :counted].mean(axis=-1))


MOST = 10_000
"""Largest number of worlds in a test."""

REPORTS = 20  # least number of progress reports, unless there are few worlds


def evaluate_unseen(
    individual: Individual,
    number: int = 100,
    *,
    seed: int = 0,
    ranges: Ranges | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda worlds: None,
) -> UnseenResults:
    """Test a gait in unseen worlds.

    The result does not depend on the number of workers. A gait from a file is played; a genome
    moves the body. Damage to the body is kept.

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
    begin(number)
    nominal = outcome_of(individual)
    outcomes = evaluate_in(individual, worlds, workers, advance, outcome_of)
    if all(one.failure for one in outcomes):
        raise GaitsimError(
            f"the motion fails in each of {number:,} worlds: {outcomes[0].failure}",
            where=individual.title,
            remedy="test another gait, or narrow the ranges of the conditions",
        )
    return UnseenResults(
        *measure_of(individual),
        nominal,
        chosen,
        {name: one.unit for name, one in conditions.items() if name in chosen},
        int(seed),
        worlds,
        outcomes,
    )


def measure_of(individual: Individual) -> tuple[str, str]:
    """Return the name and unit of an individual's results: those of `forward`, or the score's."""
    measured = individual.measurements.get(MEASURE)
    return (MEASURE, measured.unit) if measured else (SCORE, individual.experiment.fitness.unit)


def evaluate_in(
    individual: Individual,
    worlds: Sequence[World],
    workers: int | None,
    advance: Callable[[int], object],
    result_of: Callable[[Individual], Result],
) -> tuple[Result, ...]:
    """Return a result of a gait in each of several worlds, for any number of workers.

    `evaluate_unseen` describes the other arguments. `result_of` is a function of a module, such as
    `outcome_of`, that takes the gait in a world.
    """
    experiment = individual.experiment
    experiment = replace(experiment, worlds=experiment.worlds.own)
    angles = individual.joint_angles if individual.genome is None else None
    work = partial(_result_in, result_of, individual.genome, angles)
    outcomes: list[Result] = []
    with Evaluator(experiment, workers) as evaluator:
        step = evaluator.workers * max(1, len(worlds) // (REPORTS * evaluator.workers))
        for start in range(0, len(worlds), step):
            part = worlds[start : start + step]
            outcomes += evaluator.map(work, part)
            advance(len(part))
    return tuple(outcomes)


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


def _result_in(
    result_of: Callable[[Individual], Result],
    genome: Genomes | None,
    angles: Floats | None,
    experiment: Experiment,
    world: World,
) -> Result:
    """Move a genome, or play joint angles, (frames, joints), in a world."""
    moved = in_world(experiment, world)
    played = None if angles is None else play(moved, angles[None])
    return result_of(Individual(moved, math.nan, {}, genome=genome, played=played))


def outcome_of(individual: Individual) -> Outcome:
    """Return the outcome of an individual in its own world."""
    failure, score = individual.replayed_failure, individual.replayed_score
    measured = individual.measurements.get(MEASURE)
    result = score if measured is None else measured.value
    if measured is not None and (failure or not math.isfinite(result)):
        result = 0.0  # as in adaptation, a motion that failed covers no distance
    return Outcome(result, score, bool(failure) or has_fallen(individual), failure)


def has_fallen(individual: Individual) -> bool:
    """Return whether the body fell, according to its channel `lasted`, s; False without it."""
    channels, motion = individual.experiment.organism.channels, individual.motion
    lasted = channels.get("lasted")
    over_time = [name for name, one in channels.items() if one.axes[:1] == ("frames",)]
    if lasted is None or lasted.axes or lasted.unit != "s" or not over_time:
        return False
    frames = np.shape(motion[over_time[0]])[1]
    return bool(frames_in(float(motion["lasted"][0]), motion.frame_rate) < frames)
