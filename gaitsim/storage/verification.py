"""Verify that a run can be reproduced bit for bit: recorded generations are evolved again."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution import Generation, evolve, island_map, reevaluate
from gaitsim.experiment import Experiment
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.storage.consistency import (
    count_without_checksum,
    edited_options,
    inconsistencies,
    population_out_of_bounds,
    row_differences,
    wrong_checksums,
)
from gaitsim.storage.files.checkpoint import Checkpoint
from gaitsim.storage.files.folder import (
    CHECKPOINT,
    CHECKSUMS,
    POPULATIONS,
    PREVIOUS,
    kept_generations,
)
from gaitsim.storage.files.history import best_terms
from gaitsim.storage.provenance import Provenance, current_versions, differences, read_provenance
from gaitsim.storage.resume import warm_start
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import Change, restore_generation

NewEvaluator = Callable[[Experiment], Evaluator]
"""Creates the evaluator of an experiment."""

SAMPLES = 10
"""Number of generations that are reproduced by default."""


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
    for generation in _evolve_all(run, run.generation, new_evaluator):
        yield _reproduced(run, generation)


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


def _evolve_all(run: RunSnapshot, until: int, new_evaluator: NewEvaluator) -> Iterator[Generation]:
    """Yield the generations from the first up to `until`."""
    last: Generation | None = None
    for stage in run.stages:
        if stage.first <= until:
            for generation in _evolve(run, last, min(stage.last, until), new_evaluator):
                yield generation
                last = generation


def _evolve(
    run: RunSnapshot, last: Generation | None, until: int, new_evaluator: NewEvaluator
) -> Iterator[Generation]:
    """Yield the generations after `last` up to `until`, all of one stage."""
    stage = run.stage_at(until)
    experiment = _endless(run.experiment_at(until), until)
    start = warm_start(run, experiment) if last is None else None
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


def populations(run: RunSnapshot, generations: Sequence[int]) -> Iterator[Generation]:
    """Yield generations of a run with all their individuals, in order.

    If the run did not keep all of them, they are evolved again, from the first generation on. They
    must match the record.

    Raises:
        RunError: a generation does not exist, or differs from the record.
    """
    wanted = sorted({*generations})
    for number in wanted:
        run.stage_at(number)
    kept = {*wanted} <= {*kept_generations(run.path, POPULATIONS), run.generation}
    found = (
        (restore_generation(run.population(number)) for number in wanted)
        if kept
        else _evolve_all(run, wanted[-1], Evaluator)
    )
    for generation in found:
        if wrong := wrong_checksums(run, generation):
            how, remedy = "when evolved again", "use the versions and the machine that evolved it"
            if kept:
                how, remedy = f"in {POPULATIONS}", "delete its file there: it is then evolved again"
            raise RunError(
                f"generation {generation.number} differs from the record {how}: its "
                f"{' and '.join(wrong)}",
                where=str(run.path),
                remedy=remedy,
            )
        if generation.number in wanted:
            yield generation


@dataclass(frozen=True, repr=False)
class Verdict(ReprMixin):
    """The result of verifying a run.

    Attributes:
        last: last generation of the run.
        reproduced: generations that were fully reproduced.
        best_only: generations whose best individual was re-evaluated.
        differences: differences from the record, by generation in order; {} if all is identical.
        without_checksum: number of generations without a checksum.
        warning: warning about the files of the run, or ''.
        damaged: one message for each checkpoint that cannot be read.
        edited: options of `experiment.toml` that differ from those of the last generation, except
            for those that only affect when the search stops.
        origins: versions and processors that computed the run; () if not recorded.
        version_differences: one message for each difference between `origins` and the current
            versions.
        portability: class of the results and its meaning; see `Experiment.portability`.
        score_difference: largest distance of a reproduced generation's best score from the
            recorded one.
    """

    last: int
    reproduced: tuple[int, ...]
    best_only: tuple[int, ...]
    differences: Mapping[int, Sequence[str]]
    without_checksum: int
    warning: str
    damaged: tuple[str, ...]
    edited: tuple[Change, ...]
    origins: tuple[Provenance, ...]
    version_differences: tuple[str, ...]
    portability: str
    score_difference: float

    @property
    def identical(self) -> bool:
        """Whether all generations and options are identical, and all checkpoints intact."""
        return not (self.differences or self.damaged or self.edited)

    @property
    def not_reproduced(self) -> tuple[tuple[int, int], ...]:
        """The first and last generation of each span in which only the files were checked."""
        done = sorted({*self.reproduced, *self.best_only})
        gaps = zip([0, *done], [*done, self.last + 1], strict=True)
        return tuple((before + 1, after - 1) for before, after in gaps if after - before > 1)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "identical": self.identical,
            "generations": self.last,
            "reproduced": len(self.reproduced),
            "best_only": len(self.best_only),
            "different": len(self.differences) or "",
            "damaged": "; ".join(self.damaged),
        }


def sample(last: int, count: int = SAMPLES) -> list[int]:
    """Return generations spread evenly from the first to the last."""
    return sorted({int(number) for number in np.linspace(1, last, min(count, last)).round()})


def verify(
    run: RunSnapshot,
    generations: Sequence[int] | None = None,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[], None] = lambda: None,
) -> Verdict:
    """Check that a run's files are consistent, then reproduce generations and compare them.

    Args:
        run: run to verify; generations added during the verification are left out.
        generations: generations to reproduce; None for a sample.
        everything: whether to reproduce the whole run instead, up to the first difference.
        workers: number of parallel workers; None for a number that deliberately differs from the
            run's default, as the result must not depend on it.
        begin: callback with the number of generations to reproduce.
        advance: callback after each generation.
    """
    last = run.finished.generation
    _ = run.previous  # read and cached now, before the run grows
    requested = sorted({*generations}) if generations else sample(last)
    for number in (requested[0], requested[-1]):
        if not 1 <= number <= last:
            raise RunError(
                f"the run {run.path} has no generation {number}",
                where="--generations",
                allowed=f"1 to {last}",
            )
    found = inconsistencies(run)

    def new_evaluator(experiment: Experiment) -> Evaluator:
        # Not the run's default number of workers, as the result must not depend on it.
        return Evaluator(experiment, workers or (1 if experiment.organism.threads else 2))

    begin(last if everything else len(requested))
    reproduced: dict[bool, list[int]] = {True: [], False: []}
    results = (
        reproduce_all(run, new_evaluator)
        if everything
        else reproduce_some(run, requested, new_evaluator)
    )
    farthest = 0.0
    for again in results:
        reproduced[again.fully].append(again.number)
        farthest = max(farthest, again.score_difference)
        advance()
        if again.differences:
            found.setdefault(again.number, []).extend(again.differences)
            if everything:
                break
    origins = read_provenance(run.path)
    return Verdict(
        last=last,
        reproduced=tuple(reproduced[True]),
        best_only=tuple(reproduced[False]),
        differences=dict(sorted(found.items())),
        without_checksum=count_without_checksum(run),
        warning=run.warning,
        damaged=run.damaged,
        edited=edited_options(run),
        origins=tuple(origins),
        version_differences=tuple(differences(origins, current_versions(run.experiment_at(last)))),
        portability=run.portability,
        score_difference=farthest,
    )
