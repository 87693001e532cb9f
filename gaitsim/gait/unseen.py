"""A gait judged in worlds that it has not seen."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Condition, Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.worlds import (
    Ranges,
    World,
    describe,
    has_worlds,
    in_world,
    ranges_of,
    unseen,
)
from gaitsim.experiment import WORLD, Experiment, with_overrides
from gaitsim.gait.intervals import Floats
from gaitsim.gait.sensitivity import Effect, effects
from gaitsim.gait.travel import frames_in
from gaitsim.individual import Individual
from gaitsim.registry import plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin

MEASURE, SCORE = "forward", "score"
MOST = 10_000
"""Largest number of worlds that a gait is judged in."""

TRIFLE = 0.01  # of the nominal result: a smaller loss is none
REPORTS = 20  # times that progress is reported, at least


@dataclass(frozen=True)
class Outcome:
    """What became of a gait in one world.

    Attributes:
        result: the measure `forward`, or the score where the body has none.
        score: by the fitness; −inf where the motion failed.
        fell: whether it fell, or the motion failed.
        failure: why the motion failed, or ''.
    """

    result: float
    score: float
    fell: bool
    failure: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(ReprMixin):
    """What became of a gait in worlds that it has not seen.

    Attributes:
        measure: what the results are: `forward`, or `score` where the body has no such measure.
        unit: of the results.
        nominal: the outcome in the gait's own world.
        ranges: of the conditions that vary, by name.
        units: of these conditions.
        seed: of the worlds.
        worlds: the worlds.
        outcomes: in each.
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
        """(worlds,) float64, of which more is better."""
        return np.array([one.result for one in self.outcomes])

    @cached_property
    def fell(self) -> NDArray[np.bool_]:
        """In which worlds it fell, (worlds,)."""
        return np.array([one.fell for one in self.outcomes])

    @property
    def falls(self) -> int:
        """In how many worlds it fell."""
        return int(self.fell.sum())

    @property
    def failures(self) -> tuple[str, ...]:
        """Why motions failed, in the order of the worlds; () where none did."""
        return tuple(one.failure for one in self.outcomes if one.failure)

    @cached_property
    def conditions(self) -> dict[str, Floats]:
        """Values of the conditions by name, (worlds,) each."""
        return {name: np.array([world[name] for world in self.worlds]) for name in self.ranges}

    @property
    def worst_tenth(self) -> float:
        """The mean of the worst tenth of the results, one at least."""
        return float(worst_tenth(self.results))

    def quantile(self, share: float) -> float:
        """Return a quantile of the results, between neighbours in proportion."""
        if np.isfinite(self.results).all():
            return float(np.quantile(self.results, share))
        return float(np.quantile(self.results, share, method="lower"))  # −inf has no proportions

    @property
    def median(self) -> float:
        """The median of the results."""
        return self.quantile(0.5)

    def kept(self, result: float) -> float:
        """Return a result as a share of the nominal one; NaN where that is not above 0."""
        return result / self.nominal.result if self.nominal.result > 0 else math.nan

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The conditions that cost more than a trifle, beyond chance, the strongest first."""
        found = effects(self.conditions, self.ranges, self.results)
        least = TRIFLE * abs(self.nominal.result)
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
        """Return all of it as values for JSON."""
        worlds = [
            {"world": dict(world), **_outcome_to_dict(outcome)}
            for world, outcome in zip(self.worlds, self.outcomes, strict=True)
        ]
        return {**self.statistics(), "worlds": worlds}

    def statistics(self) -> dict[str, Any]:
        """Return it as values for JSON, without the single worlds."""
        return {
            "measure": self.measure,
            "unit": self.unit,
            "number": len(self.worlds),
            "seed": self.seed,
            "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            "nominal": _outcome_to_dict(self.nominal),
            "worst_tenth": self.worst_tenth,
            "worst": self.quantile(0),
            "q25": self.quantile(0.25),
            "median": self.median,
            "q75": self.quantile(0.75),
            "best": self.quantile(1),
            "kept_worst_tenth": self.kept(self.worst_tenth),
            "kept_median": self.kept(self.median),
            "falls": self.falls,
            "effects": [
                {
                    "condition": one.condition,
                    "share": one.share,
                    "p": one.p,
                    "hurting": [list(ends) for ends in one.hurting],
                    "loss": one.loss,
                }
                for one in self.effects
            ],
        }


def worst_tenth(results: Floats) -> Floats:
    """Return the mean of the worst tenth, one at least, of results, (…, worlds)."""
    counted = -(-results.shape[-1] // 10)
    return np.asarray(np.sort(results, axis=-1)[..., :counted].mean(axis=-1))


def judge(
    individual: Individual,
    number: int = 100,
    *,
    seed: int = 0,
    ranges: Ranges | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda worlds: None,
) -> Judgement:
    """Judge a gait in worlds that it has not seen.

    The result does not depend on the number of workers. A gait from a file is played, a genome
    moves the body. Damage to the body stays.

    Args:
        individual: of a run or from a file.
        number: of worlds, from 1 to `MOST`.
        seed: for other worlds. The same seed and ranges are the same worlds for all gaits.
        ranges: of the conditions that vary, by name; None for those of the experiment's worlds, or
            else the usual ones of all conditions of the body, without those that the world of a
            changed individual names.
        workers: how many work at a time; None for what suits the body.
        begin: called with the number of worlds.
        advance: called with a number of worlds when they are done.

    Raises:
        GaitsimError: the body has no conditions, or the number or the seed is invalid, or the
            motion fails in every world.
        PluginError: the body or the fitness fails or breaks its contract.
    """
    check_request(number, seed)
    experiment = replace(individual.experiment, worlds=individual.experiment.worlds.own)
    conditions = conditions_of(experiment)
    chosen = _varying(individual) if ranges is None else _checked(experiment, ranges)
    worlds = unseen(experiment, number, chosen, seed)
    begin(number)
    nominal = _outcome(individual)
    measured = individual.measurements.get(MEASURE)
    angles = individual.joint_angles if individual.genome is None else None
    work = partial(_outcome_in, individual.genome, angles)
    outcomes: list[Outcome] = []
    with Evaluator(experiment, workers) as evaluator:
        at_once = evaluator.workers * max(1, number // (REPORTS * evaluator.workers))
        for start in range(0, number, at_once):
            part = worlds[start : start + at_once]
            outcomes += evaluator.map(work, part)
            advance(len(part))
    if all(one.failure for one in outcomes):
        raise GaitsimError(
            f"the motion fails in each of {number:,} worlds: {outcomes[0].failure}",
            where=individual.title,
            remedy="judge another gait, or narrow the ranges of the conditions",
        )
    return Judgement(
        MEASURE if measured else SCORE,
        measured.unit if measured else experiment.fitness.unit,
        nominal,
        chosen,
        {name: one.unit for name, one in conditions.items() if name in chosen},
        int(seed),
        worlds,
        tuple(outcomes),
    )


def check_request(number: object, seed: object) -> None:
    """Check a number of worlds and their seed.

    Raises:
        GaitsimError: one is invalid.
    """
    for value, what, least, most in (
        (number, "number of worlds", 1, MOST),
        (seed, "seed of worlds", 0, 2**53 - 1),
    ):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not (whole and least <= value <= most):  # type: ignore[operator]
            raise GaitsimError(
                f"{value!r} is not a {what}", allowed=f"a whole number from {least} to {most:,}"
            )


def conditions_of(experiment: Experiment) -> Mapping[str, Condition]:
    """Return the conditions of the body that vary between worlds, by name.

    Raises:
        GaitsimError: it has none.
    """
    entry = experiment.entries["organism"]
    with plugin_errors(entry, "naming its conditions"):
        found = experiment.organism.conditions() if has_worlds(experiment) else {}
    if not found:
        raise GaitsimError(
            f"the body {entry.name!r} has one world alone",
            where=experiment.name,
            allowed="a body with conditions, such as the walker",
        )
    return found


def _varying(individual: Individual) -> Ranges:
    fixed = individual.changes.get(f"organism.{WORLD}", {})
    ranges = ranges_of(individual.experiment)
    varying = {name: ends for name, ends in ranges.items() if name not in fixed}
    if not varying:
        raise GaitsimError(
            "every condition that varies between worlds has a fixed value",
            where=describe(fixed),
            allowed=f"at least one of {', '.join(ranges)} that varies",
        )
    return varying


def _checked(experiment: Experiment, ranges: Ranges) -> Ranges:
    told = with_overrides(experiment, {"worlds.ranges": {n: [*ends] for n, ends in ranges.items()}})
    return ranges_of(told)


def _outcome_in(
    genome: Genomes | None, angles: Floats | None, experiment: Experiment, world: World
) -> Outcome:
    """Move a genome, or play joint angles, (frames, joints), in a world."""
    there = in_world(experiment, world)
    played = None if angles is None else play(there, angles[None])
    return _outcome(Individual(there, math.nan, {}, genome=genome, played=played))


def _outcome(individual: Individual) -> Outcome:
    failure, score = individual.replayed_failure, individual.replayed_score
    measured = individual.measurements.get(MEASURE)
    result = score if measured is None else measured.value
    if measured is not None and (failure or not math.isfinite(result)):
        result = 0.0  # as for adaptation: what fails goes nowhere
    return Outcome(result, score, bool(failure) or _fell(individual), failure)


def _fell(individual: Individual) -> bool:
    """Return whether the body fell, by its channel `lasted`, s; False without one."""
    channels, motion = individual.experiment.organism.channels, individual.motion
    lasted = channels.get("lasted")
    over_time = [name for name, one in channels.items() if one.axes[:1] == ("frames",)]
    if lasted is None or lasted.axes or lasted.unit != "s" or not over_time:
        return False
    frames = np.shape(motion[over_time[0]])[1]
    return bool(frames_in(float(motion["lasted"][0]), motion.frame_rate) < frames)


def _outcome_to_dict(outcome: Outcome) -> dict[str, Any]:
    return {
        "result": outcome.result,
        "score": outcome.score,
        "fell": outcome.fell,
        "failure": outcome.failure or None,
    }
