"""Reproduce recorded generations of a run, and report differences from the record."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution import Generation, evolve, island_map, reevaluate
from gaitsim.experiment import Experiment
from gaitsim.runs.files.checkpoint import Checkpoint
from gaitsim.runs.files.folder import CHECKPOINT, CHECKSUMS, PREVIOUS
from gaitsim.runs.files.history import best_terms
from gaitsim.runs.resume import start_genome
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.stages import restore_generation
from gaitsim.runs.verify.consistency import (
    population_out_of_bounds,
    row_differences,
    wrong_checksums,
)

NewEvaluator = Callable[[Experiment], Evaluator]
"""Creates the evaluator of an experiment."""


class Reproduced(NamedTuple):
    """A reproduced generation.

    Attributes:
        number: number of the generation.
        fully: whether the whole generation was reproduced, not only its best individual.
        differences: its differences from the record.
        score_difference: distance of the best score from the recorded one.
    """

    number: int
    fully: bool
    differences: list[str]
    score_difference: float


def reproduce_all(run: RunSnapshot, new_evaluator: NewEvaluator) -> Iterator[Reproduced]:
    """Reproduce the whole run from its experiments, stage by stage."""
    last: Generation | None = None
    for stage in run.stages:
        for generation in _evolve(run, last, stage.last, new_evaluator):
            yield _reproduced(run, generation)
            last = generation


def reproduce_some(
    run: RunSnapshot, generations: list[int], new_evaluator: NewEvaluator
) -> Iterator[Reproduced]:
    """Reproduce some generations, in full if the previous population is stored.

    The first generation needs no previous population. The last one is reproduced from the previous
    checkpoint, if that exists, which is at most half a second of computing before it. In all other
    generations, only the best individual is re-evaluated.
    """
    for number in generations:
        before = None
        previous = run.previous if number == run.generation else None
        if previous is not None and not population_out_of_bounds(run, previous):
            before = restore_generation(previous)
        if number == 1 or before is not None:
            *_, generation = _evolve(run, before, number, new_evaluator)
            yield _reproduced(run, generation)
            continue
        with new_evaluator(run.experiment_at(number)) as evaluator:
            found, distance = _best_differences(run, number, evaluator.evaluate)
            if number == run.generation:
                again = evaluator.evaluate(run.finished.genomes, number)
                found += _score_differences(run.finished, CHECKPOINT, again)
        yield Reproduced(number, False, found, distance)


def _evolve(
    run: RunSnapshot, last: Generation | None, until: int, new_evaluator: NewEvaluator
) -> Iterator[Generation]:
    """Yield the generations after `last` up to `until`, all of one stage."""
    stage = run.stage_at(until)
    experiment = _endless(run.experiment_at(until), until)
    start = start_genome(run, experiment) if last is None else None
    with new_evaluator(experiment) as evaluator:
        if last is not None and last.number < stage.first:
            progress = last.progress.next_stage(
                experiment.evolution.fitness_threshold,
                reevaluated=stage.reevaluated,
                population=len(last.genomes),
            )
            last = replace(last, progress=progress)
            if stage.reevaluated:
                last = reevaluate(experiment, last, evaluator.evaluate)
        yield from evolve(experiment, evaluator.evaluate, last, start, island_map(evaluator))


def _endless(experiment: Experiment, generations: int) -> Experiment:
    """Return the experiment with the number of generations as its only stop condition."""
    never = {"target_score": None, "max_evaluations": None, "stagnation": None}
    evolution = experiment.evolution.model_copy(update={"generations": generations, **never})
    return replace(experiment, evolution=evolution)


def _reproduced(run: RunSnapshot, again: Generation) -> Reproduced:
    """Return how a fully reproduced generation differs from the record.

    Champions are left out, as `consistency` compares them with the record.
    """
    found = [
        f"the reproduced {part} do not match {CHECKSUMS}" for part in wrong_checksums(run, again)
    ] + row_differences(run, again, "when reproduced")
    for checkpoint, name in ((run.finished, CHECKPOINT), (run.previous, PREVIOUS)):
        if checkpoint is not None and checkpoint.generation == again.number:
            found += _checkpoint_differences(checkpoint, name, again)
    score = float(again.scores[again.best])
    return Reproduced(again.number, True, found, _score_distance(run, again.number, score))


def _score_distance(run: RunSnapshot, number: int, score: float) -> float:
    """Return the distance of a generation's best score from the recorded one; 0 if both failed."""
    recorded = float(run.bests[number - 1]["score"])
    return 0.0 if recorded == score else abs(recorded - score)


def _checkpoint_differences(checkpoint: Checkpoint, name: str, again: Generation) -> list[str]:
    found = []
    if checkpoint.genomes.shape != again.genomes.shape:
        found.append(f"{name}: the population has a different size")
    else:
        individuals, genes = np.nonzero(checkpoint.genomes != again.genomes)
        if len(genes):
            found.append(f"{name}: gene {genes[0] + 1} of individual {individuals[0]} differs")
        found += _score_differences(checkpoint, name, again.evaluation)
    for array, values in again.state.items():
        if not np.array_equal(checkpoint.state.get(array, np.empty(0)), values, equal_nan=True):
            found.append(f"{name}: the search's {array} differs")
    if checkpoint.best_score != again.progress.best_score:
        found.append(f"{name}: the best score so far differs")
    if checkpoint.stagnation != again.progress.stagnation:
        found.append(f"{name}: the stagnation differs")
    return found


def _score_differences(checkpoint: Checkpoint, name: str, again: Evaluation) -> list[str]:
    found = []
    wrong = np.flatnonzero(checkpoint.scores != again.scores)
    if len(wrong):
        then, now = float(checkpoint.scores[wrong[0]]), float(again.scores[wrong[0]])
        found.append(
            f"{name}: the score of individual {wrong[0]} is {then!r}, but {now!r} when reproduced"
        )
    for term, values in checkpoint.terms.items():
        if not np.array_equal(values, again.terms.get(term, np.empty(0)), equal_nan=True):
            found.append(f"{name}: the term {term} differs")
    return found


def _best_differences(run: RunSnapshot, number: int, evaluate: Evaluate) -> tuple[list[str], float]:
    """Re-evaluate a generation's best individual.

    Returns:
        The differences from the record, and the distance of the score from the recorded one.
    """
    best, kept = run.bests[number - 1], best_terms(run.history, number)
    try:
        genome = run.best_genome(number)
    except RunError as error:
        return [error.what], 0.0
    again = evaluate(genome[None], number)
    then = {"score": float(best["score"])} | {f"term {name}": kept[name] for name in kept}
    now = {"score": float(again.scores[0])}
    now |= {f"term {name}": float(values[0]) for name, values in again.terms.items()}
    found = [
        f"the {what} of its best individual is {then.get(what)!r}, but {value!r} when reproduced"
        for what, value in now.items()
        if not math.isnan(value) and then.get(what) != value
    ]
    return found, _score_distance(run, number, now["score"])
