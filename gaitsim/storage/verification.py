"""Verify that a run can be reproduced bit for bit: recorded generations are evolved again."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution import Generation, evolve, island_map, reevaluate
from gaitsim.experiment import Experiment
from gaitsim.opening import is_folder
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.storage.accounts import Account
from gaitsim.storage.consistency import (
    inconsistencies,
    population_out_of_bounds,
    row_differences,
    wrong_checksums,
)
from gaitsim.storage.files.checkpoint import Checkpoint
from gaitsim.storage.files.folder import (
    ADAPTATIONS,
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    HISTORY,
    ISLANDS,
    POPULATIONS,
    PREVIOUS,
    PROVENANCE,
    SAVES,
    START,
    kept_file,
    kept_generations,
)
from gaitsim.storage.files.history import best_terms
from gaitsim.storage.provenance import Provenance, current_versions, differences, read_provenance
from gaitsim.storage.resume import warm_start
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import Change, begin_stage, restore_generation

NewEvaluator = Callable[[Experiment], Evaluator]
"""Creates the evaluator of an experiment."""

SAMPLES = 10
"""Number of generations that are evolved again in a part of a run, if their parents are kept."""

QUICK = 60.0
"""Runs that took at most this long are evolved again as a whole by default, seconds."""

BATCH = 256
"""Number of best individuals that are evaluated together."""


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
    run: RunSnapshot,
    stored: Mapping[int, Checkpoint],
    full: Sequence[int],
    best_only: Sequence[int],
    new_evaluator: NewEvaluator,
) -> Iterator[Reproduced]:
    """Evolve some generations again, and evaluate the best individual of others.

    Args:
        run: the run.
        stored: populations of `stored_populations`.
        full: generations that `reproducible` returns.
        best_only: other generations.
        new_evaluator: function that creates evaluators.
    """
    for parent, group in groupby(full, lambda number: max([0, *(n for n in stored if n < number)])):
        numbers = [*group]
        before = restore_generation(stored[parent]) if parent else None
        for generation in _evolve(run, before, numbers[-1], new_evaluator):
            if generation.number in numbers:
                yield _reproduced(run, generation)
    for stage in run.stages:
        within = [number for number in best_only if stage.first <= number <= stage.last]
        if not within:
            continue
        worlds = stage.outline.worlds
        with new_evaluator(run.experiment_at(stage.last)) as evaluator:
            for _, group in groupby(within, worlds.first_of_draw):
                same_worlds = [*group]
                for at in range(0, len(same_worlds), BATCH):
                    batch = same_worlds[at : at + BATCH]
                    yield from _reevaluated_bests(run, batch, evaluator.evaluate)


def reproducible(run: RunSnapshot, stored: Mapping[int, Checkpoint]) -> list[int]:
    """Return the generations that can be evolved again on their own.

    These are the first, the one after each kept population, and those after the previous
    checkpoint, which are at most half a second of computing.
    """
    last = run.previous.generation + 1 if run.previous else run.generation + 1
    after = {number + 1 for number in stored}
    return sorted({1, *after, *range(last, run.generation + 1)})


def stored_populations(run: RunSnapshot) -> dict[int, Checkpoint]:
    """Return the populations from which the run can continue, by generation in order."""
    found = {}
    for number in run.kept_populations:
        with suppress(GaitsimError):  # `consistency` reports it
            found[number] = run.population(number)
    if run.previous is not None:
        found[run.previous.generation] = run.previous
    return {
        number: found[number]
        for number in sorted(found)
        if not population_out_of_bounds(run, found[number])
    }


def _reevaluated_bests(
    run: RunSnapshot, numbers: Sequence[int], evaluate: Evaluate
) -> Iterator[Reproduced]:
    """Evaluate the best individuals of generations of one stage with the same worlds."""
    genomes, wrong = {}, {}
    for number in numbers:
        try:
            genomes[number] = run.best_genome(number)
        except RunError as error:
            wrong[number] = error.what
    again = evaluate(np.stack([*genomes.values()]), numbers[0]) if genomes else None
    for number in numbers:
        if again is None or number in wrong:
            yield Reproduced(number, False, [wrong[number]], 0.0)
            continue
        at = [*genomes].index(number)
        kept = best_terms(run.history, number)
        then = {"score": float(run.bests[number - 1]["score"])}
        then |= {f"term {name}": value for name, value in kept.items()}
        now = {"score": float(again.scores[at])}
        now |= {f"term {name}": float(values[at]) for name, values in again.terms.items()}
        found = [
            f"the {what} of its best individual is {then.get(what)!r}, but {value!r} when "
            "reproduced"
            for what, value in now.items()
            if not math.isnan(value) and then.get(what) != value
        ]
        if number == run.generation:
            population = evaluate(run.finished.genomes, number)
            found += _score_differences(run.finished, CHECKPOINT, population)
            found += _member_differences(run, evaluate)
        yield Reproduced(number, False, found, _score_distance(run, number, now["score"]))


def _member_differences(run: RunSnapshot, evaluate: Evaluate) -> list[str]:
    """Evaluate the members of the front or archive again; return their differences."""
    members = run.members
    if members is None or not len(members.scores):
        return []
    again = evaluate(members.genomes, run.generation)
    found = {**again.terms, **again.values, "score": again.scores}
    return [
        f"{CHECKPOINT}: the {name} of member {wrong[0] + 1} is {float(values[wrong[0]])!r}, but "
        f"{float(found[name][wrong[0]])!r} when reproduced"
        for name, values in {**members.values, "score": members.scores}.items()
        if name in found and len(wrong := np.flatnonzero(values != found[name]))
    ]


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
            progress = begin_stage(
                last.progress, experiment.evolution, stage.changes, len(last.genomes)
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
    stored = [(run.finished, CHECKPOINT), (run.previous, PREVIOUS)]
    if again.number in run.kept_populations:
        with suppress(GaitsimError):  # `consistency` reports it
            name = kept_file(POPULATIONS, again.number)
            stored.append((run.population(again.number), name))
    for checkpoint, name in stored:
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
    for array in sorted({*again.state, *checkpoint.state}):
        then, now = (one.get(array, np.empty(0)) for one in (checkpoint.state, again.state))
        if then.dtype != now.dtype or not np.array_equal(then, now, equal_nan=True):
            found.append(f"{name}: the search's {array} differs")
    return found


def _score_differences(checkpoint: Checkpoint, name: str, again: Evaluation) -> list[str]:
    found = []
    wrong = np.flatnonzero(checkpoint.scores != again.scores)
    if len(wrong):
        then, now = float(checkpoint.scores[wrong[0]]), float(again.scores[wrong[0]])
        found.append(
            f"{name}: the score of individual {wrong[0]} is {then!r}, but {now!r} when reproduced"
        )
    parts = ("term", checkpoint.terms, again.terms), ("value", checkpoint.values, again.values)
    for part, recorded, reproduced in parts:
        for key in sorted({*recorded, *reproduced}):
            values = recorded.get(key, np.empty(0))
            if not np.array_equal(values, reproduced.get(key, np.empty(0)), equal_nan=True):
                found.append(f"{name}: the {part} {key} differs")
    for index, reason in checkpoint.reasons.items():
        if again.reasons.get(int(index)) != reason:
            found.append(f"{name}: the reason of failure of individual {index} differs")
    return found


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
    # Not the snapshot's list: a user deletes a file that differs, to have it evolved again.
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
        accounts: comparisons of each file.
    """

    last: int
    reproduced: tuple[int, ...]
    best_only: tuple[int, ...]
    differences: Mapping[int, Sequence[str]]
    warning: str
    damaged: tuple[str, ...]
    edited: tuple[Change, ...]
    origins: tuple[Provenance, ...]
    version_differences: tuple[str, ...]
    portability: str
    score_difference: float
    accounts: tuple[Account, ...]

    @property
    def identical(self) -> bool:
        """Whether all that was compared is identical, and no checkpoint is invalid."""
        return not (self.differences or self.damaged or self.edited)

    @property
    def complete(self) -> bool:
        """Whether every generation was reproduced in full, so that none can be forged."""
        return len(self.reproduced) == self.last

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


def verify(
    run: RunSnapshot,
    generations: Sequence[int] | None = None,
    *,
    everything: bool | None = None,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[], None] = lambda: None,
) -> Verdict:
    """Check that a run's files are consistent, then reproduce generations and compare them.

    Args:
        run: run to verify; generations added during the verification are left out.
        generations: generations to reproduce, of which those whose parents are not kept by their
            best individual only; None for the whole run or a part of it.
        everything: whether to evolve the whole run again, up to the first difference; None does so
            if it took at most `QUICK`. A part has `SAMPLES` generations whose parents are kept, and
            the best individuals of all others.
        workers: number of parallel workers; None for a number that deliberately differs from the
            run's default, as the result must not depend on it.
        begin: callback with the number of generations to reproduce.
        advance: callback after each generation.
    """
    last = run.finished.generation
    _ = run.previous, run.saves  # read and cached now, before the run grows
    for number in (min(generations), max(generations)) if generations else ():
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

    if everything is None:
        everything = not generations and float(run.history["seconds"].sum()) <= QUICK
    if everything:
        begin(last)
        results = reproduce_all(run, new_evaluator)
    else:
        stored = stored_populations(run)
        able = reproducible(run, stored)
        if generations:
            asked = sorted({*generations})
            full = [number for number in asked if number in able]
        else:
            asked = [*range(1, last + 1)]
            full = sorted({*able[:: max(len(able) // SAMPLES, 1)], 1, last} & {*able})
        begin(len(asked))
        others = sorted({*asked} - {*full})
        results = reproduce_some(run, stored, full, others, new_evaluator)
    reproduced: dict[bool, list[int]] = {True: [], False: []}
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
        warning=run.warning,
        damaged=run.damaged,
        edited=run.pending,
        origins=tuple(origins),
        version_differences=tuple(differences(origins, current_versions(run.experiment_at(last)))),
        portability=run.portability,
        score_difference=farthest,
        accounts=_accounts(run, reproduced[True], reproduced[False]),
    )


def _accounts(
    run: RunSnapshot, full: Sequence[int], best_only: Sequence[int]
) -> tuple[Account, ...]:
    """Return the comparisons of each file of a run, given the reproduced generations."""
    last, again = run.generation, "evolved again"
    consistent = "compared with history, bests and checksums"
    done = f"{len(full):,} of {last:,} generations {again}"
    evaluated = f"{len(full) + len(best_only):,} of {last:,} evaluated again"
    populations = {PREVIOUS: run.previous, CHECKPOINT: run.finished}
    champions, kept = (
        kept_generations(run.path, folder, last) for folder in (CHAMPIONS, POPULATIONS)
    )
    rows = [
        Account(EXPERIMENT, "compared with the last generation", "name, description and limits"),
        *(
            Account(name, f"generation {one.generation} {again}")
            if one.generation in full
            else Account(name, consistent, "the state of the search")
            for name, one in populations.items()
            if one is not None
        ),
        Account(HISTORY, done, "seconds" if len(full) == last else "the other rows; seconds"),
        Account(BESTS, evaluated),
        Account(CHECKSUMS, f"all {last:,} computed again from the files"),
        Account(SAVES, f"compared with {CHECKPOINT}", "whether the run was once longer"),
        Account(f"{CHAMPIONS}/", f"{len(champions):,}, as the threshold demands; {consistent}"),
    ]
    if run.islands.shape[1] > 1:
        rows.insert(-3, Account(ISLANDS, done))
    if kept:
        also = sum(number in full for number in kept)
        rows.append(Account(f"{POPULATIONS}/", f"{also:,} of {len(kept):,} {again}; {consistent}"))
    if run.start is not None:
        rows.append(Account(START, f"generation 1 {again} from it" if 1 in full else "not used"))
    if is_folder(run.path / ADAPTATIONS):
        rows.append(Account(f"{ADAPTATIONS}/", "not compared", "trials: verify each of its files"))
    rows.append(Account(PROVENANCE, "compared with this machine", "what it states of the past"))
    return tuple(rows)
