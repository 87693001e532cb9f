"""Test a gait in unseen worlds, in which it did not evolve."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

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
from gaitsim.gait.intervals import Floats
from gaitsim.gait.travel import frames_in
from gaitsim.gait.unseen_results import MEASURE, SCORE, Outcome, UnseenResults
from gaitsim.individual import Individual

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
    experiment = replace(individual.experiment, worlds=individual.experiment.worlds.own)
    conditions = conditions_of(experiment)
    chosen = _varying_ranges(individual) if ranges is None else _check_ranges(experiment, ranges)
    worlds = draw_unseen_worlds(experiment, number, chosen, seed)
    begin(number)
    nominal = _outcome(individual)
    measured = individual.measurements.get(MEASURE)
    angles = individual.joint_angles if individual.genome is None else None
    work = partial(_outcome_in, individual.genome, angles)
    outcomes: list[Outcome] = []
    with Evaluator(experiment, workers) as evaluator:
        step = evaluator.workers * max(1, number // (REPORTS * evaluator.workers))
        for start in range(0, number, step):
            part = worlds[start : start + step]
            outcomes += evaluator.map(work, part)
            advance(len(part))
    if all(one.failure for one in outcomes):
        raise GaitsimError(
            f"the motion fails in each of {number:,} worlds: {outcomes[0].failure}",
            where=individual.title,
            remedy="test another gait, or narrow the ranges of the conditions",
        )
    return UnseenResults(
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
        GaitsimError: the number or the seed is invalid.
    """
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


def _outcome_in(
    genome: Genomes | None, angles: Floats | None, experiment: Experiment, world: World
) -> Outcome:
    """Move a genome, or play joint angles, (frames, joints), in a world."""
    moved = in_world(experiment, world)
    played = None if angles is None else play(moved, angles[None])
    return _outcome(Individual(moved, math.nan, {}, genome=genome, played=played))


def _outcome(individual: Individual) -> Outcome:
    failure, score = individual.replayed_failure, individual.replayed_score
    measured = individual.measurements.get(MEASURE)
    result = score if measured is None else measured.value
    if measured is not None and (failure or not math.isfinite(result)):
        result = 0.0  # as in adaptation, a motion that failed covers no distance
    return Outcome(result, score, bool(failure) or _fell(individual), failure)


def _fell(individual: Individual) -> bool:
    """Return whether the body fell, according to its channel `lasted`, s; False without it."""
    channels, motion = individual.experiment.organism.channels, individual.motion
    lasted = channels.get("lasted")
    over_time = [name for name, one in channels.items() if one.axes[:1] == ("frames",)]
    if lasted is None or lasted.axes or lasted.unit != "s" or not over_time:
        return False
    frames = np.shape(motion[over_time[0]])[1]
    return bool(frames_in(float(motion["lasted"][0]), motion.frame_rate) < frames)
