"""Reproduce recorded generations of a run, and report what differs from the record."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from gaitsim.errors import CheckpointError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evolution import Generation, evolve, island_map
from gaitsim.experiment import Experiment
from gaitsim.runs.files.checkpoint import Checkpoint
from gaitsim.runs.files.checksums import genomes_checksum, scores_checksum
from gaitsim.runs.files.folder import CHECKPOINT, PREVIOUS, champion_file
from gaitsim.runs.files.history import best_terms
from gaitsim.runs.resume import restored
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.start import start_genome
from gaitsim.runs.verify.consistency import checksum, row_differences

Judges = Callable[[Experiment], Evaluator]
"""Makes an evaluator of an experiment."""


def reproduce_all(run: RunSnapshot, judges: Judges) -> Iterator[tuple[Generation, list[str]]]:
    """Evolve the whole run again, from its file alone, stage by stage.

    Yields:
        Each generation, and what differs from the record.

    Raises:
        GaitsimError: an experiment has problems, or a plugin fails.
    """
    last: Generation | None = None
    for stage in run.stages:
        for generation in _goes_on(run, last, stage.last, judges):
            yield generation, differences(run, generation)
            last = generation


def reproduce_some(
    run: RunSnapshot, generations: list[int], judges: Judges
) -> Iterator[tuple[int, bool, list[str]]]:
    """Reproduce some generations, fully where the population that they were bred from is stored.

    That is the first one, and the last one out of the checkpoint before it. Of any other, the
    best individual is re-evaluated.

    Args:
        run: the run.
        generations: in order.
        judges: evaluators.

    Yields:
        Each one's number, whether it was fully reproduced, and what differs from the record.

    Raises:
        GaitsimError: an experiment has problems, or a plugin fails.
    """
    for number in generations:
        before = None
        if number == run.generation and run.previous is not None:
            before = restored(run.previous)
        if number == 1 or before is not None:
            (generation,) = _goes_on(run, before, number, judges)
            yield number, True, differences(run, generation)
            continue
        with judges(run.experiment_at(number)) as evaluator:
            found = _best_again(run, number, evaluator.evaluate)
            if number == run.generation:
                found += _population_again(run, evaluator.evaluate)
        yield number, False, found


def _goes_on(
    run: RunSnapshot, last: Generation | None, until: int, judges: Judges
) -> Iterator[Generation]:
    """The generations after `last` up to `until`, all of one stage."""
    stage = run.stage_at(until)
    experiment = endless(run.experiment_at(until), until)
    start = start_genome(run, experiment) if last is None else None
    with judges(experiment) as evaluator:
        if last is not None and last.number < stage.first and stage.number > 1:
            progress = last.progress.next_stage(
                experiment.evolution,
                reevaluated=stage.reevaluated,
                population=len(last.genomes),
            )
            last = (
                last.reevaluated(evaluator.evaluate, progress)
                if stage.reevaluated
                else replace(last, progress=progress)
            )
        yield from evolve(experiment, evaluator.evaluate, last, start, island_map(evaluator))


def endless(experiment: Experiment, generations: int) -> Experiment:
    """The same experiment, to be stopped by nothing before so many generations."""
    never = {"target_score": None, "max_evaluations": None, "stagnation": None}
    evolution = experiment.evolution.model_copy(update={"generations": generations, **never})
    return replace(experiment, evolution=evolution)


def differences(run: RunSnapshot, again: Generation) -> list[str]:
    """What a generation that was made again is not as recorded, a text each."""
    number = again.number
    found = []
    for part, expected in (
        ("genomes", genomes_checksum(again.genomes)),
        ("scores", scores_checksum(again.evaluation)),
    ):
        if checksum(run, number, part) not in (None, expected):
            found.append(f"the {part} of the population are others")
    found += row_differences(run, again)
    if number == run.generation:
        found += _unlike(run.finished, CHECKPOINT, again)
    elif run.previous is not None and number == run.previous.generation:
        found += _unlike(run.previous, PREVIOUS, again)
    champion = run.champions.get(number)
    if isinstance(champion, CheckpointError):
        found.append(champion.what)
    elif champion is not None and not np.array_equal(champion.genome, again.genomes[again.best]):
        found.append(f"{champion_file(number)} holds another genome")
    return found


def _unlike(checkpoint: Checkpoint, name: str, again: Generation) -> list[str]:
    """What of a checkpoint is not as in its generation made again."""
    found = []
    if checkpoint.genomes.shape != again.genomes.shape:
        found.append(f"{name}: the population has another size")
    else:
        individuals, genes = np.nonzero(checkpoint.genomes != again.genomes)
        if len(genes):
            found.append(f"{name}: gene {genes[0] + 1} of individual {individuals[0]} is another")
        found += _unlike_scores(checkpoint, name, again.evaluation)
    if checkpoint.best_score != again.progress.best_score:
        found.append(f"{name}: the best score so far is another")
    if checkpoint.stagnation != again.progress.stagnation:
        found.append(f"{name}: the generations since it rose are others")
    return found


def _unlike_scores(checkpoint: Checkpoint, name: str, again: Evaluation) -> list[str]:
    found = []
    wrong = np.flatnonzero(checkpoint.scores != again.scores)
    if len(wrong):
        then, now = float(checkpoint.scores[wrong[0]]), float(again.scores[wrong[0]])
        found.append(f"{name}: the score of individual {wrong[0]} is {then!r}, but {now!r}")
    for term, values in checkpoint.terms.items():
        if not np.array_equal(values, again.terms.get(term, np.empty(0)), equal_nan=True):
            found.append(f"{name}: the term {term} is another")
    return found


def _best_again(run: RunSnapshot, number: int, evaluate: Callable[..., Evaluation]) -> list[str]:
    """Return what differs when a generation's best individual is re-evaluated."""
    best = run.bests[number - 1]
    genome = best["genome"].astype(run.experiment_at(number).space().dtype)
    evaluation = evaluate(genome[None])
    found = []
    then, now = float(best["score"]), float(evaluation.scores[0])
    if then != now:
        found.append(f"the score of its best individual is {then!r}, but {now!r}")
    kept = best_terms(run.history, number)
    for term, values in evaluation.terms.items():
        value = float(values[0])
        if not np.isnan(value) and kept.get(term) != value:
            found.append(
                f"the term {term} of its best individual is {kept.get(term)!r}, but {value!r}"
            )
    return found


def _population_again(run: RunSnapshot, evaluate: Callable[..., Evaluation]) -> list[str]:
    checkpoint = run.finished
    return _unlike_scores(checkpoint, CHECKPOINT, evaluate(checkpoint.genomes))
