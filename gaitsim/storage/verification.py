"""Verify a run: its files are compared with one another, and its generations evolved again."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.errors import CheckpointError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import (
    Generation,
    evolve,
    island_map,
)
from gaitsim.experiment import Experiment, read_outline
from gaitsim.opening import is_folder, read_regular
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.storage.compatibility import out_of_bounds
from gaitsim.storage.files.checkpoint import Checkpoint, read_champion
from gaitsim.storage.files.folder import (
    ADAPTATIONS,
    ALL_SCORES,
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    HISTORY,
    ISLANDS,
    MEASURES,
    PREVIOUS,
    PROVENANCE,
    SAVES,
    START,
    champion_file,
    champion_generations,
)
from gaitsim.storage.files.history import (
    best_terms,
    island_bests,
    islands_record,
    row,
    terms_of,
)
from gaitsim.storage.files.records import (
    NONE,
    RECORD,
    SAVE,
    chain_checksum,
    genomes_checksum,
    scores_checksum,
)
from gaitsim.storage.files.scores import block_ends, scores_of
from gaitsim.storage.files.tables import line_ends
from gaitsim.storage.lock import is_locked
from gaitsim.storage.measured import Measured, read_measured
from gaitsim.storage.provenance import Provenance, current_versions, differences, read_provenance
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import begin_again, changes, restore_generation
from gaitsim.toml import brief

QUICK = 60.0
"""Runs that took at most this long are evolved again as a whole by default, seconds."""

BATCH = 256
"""Number of best individuals that are evaluated together."""

LIMITS = {"target_score": None, "max_evaluations": None, "stagnation": None}


class FileDifference(NamedTuple):
    """A difference between a file and what it should contain.

    Attributes:
        file: name of the file in the folder.
        what: what is different.
        generation: generation of the difference; 0 if it belongs to none.
    """

    file: str
    what: str
    generation: int = 0

    def __str__(self) -> str:
        """Return the difference as one line."""
        place = f"generation {self.generation}: " if self.generation else ""
        return f"{place}{self.file}: {self.what}"


class FileResult(NamedTuple):
    """The result for one file or folder.

    Attributes:
        file: name of the file or folder.
        result: whether its content is as computed again.
        about: how it was compared, or which part of it cannot be known.
    """

    file: str
    result: Literal["same", "differs", "cannot be known"]
    about: str = ""


@dataclass(frozen=True, repr=False)
class Verdict(ReprMixin):
    """The result of verifying a run, a study, a comparison or an adaptation.

    Attributes:
        kind: 'run', 'study', 'comparison' or 'adaptation'.
        parts: the parts that can be repeated, and how, such as 'generations evolved'.
        total: number of these parts.
        again: numbers of the parts that were repeated.
        complete: whether everything was repeated, so that nothing can be forged.
        differences: the differences; () if all is identical.
        files: the result for each file.
        notes: limits of the verification and warnings, one sentence each.
        origins: versions and processors that computed a run; () if not recorded.
        version_differences: one message for each difference between `origins` and the current
            versions.
        portability: class of a run's results and its meaning; see `Experiment.portability`.
        score_difference: largest distance of a reproduced generation's best score from the
            recorded one.
    """

    kind: str
    parts: str
    total: int
    again: tuple[int, ...]
    complete: bool
    differences: tuple[FileDifference, ...]
    files: tuple[FileResult, ...]
    notes: tuple[str, ...] = ()
    origins: tuple[Provenance, ...] = ()
    version_differences: tuple[str, ...] = ()
    portability: str = ""
    score_difference: float = 0.0

    @property
    def identical(self) -> bool:
        """Whether everything that was compared is identical."""
        return not self.differences

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "kind": self.kind,
            "identical": self.identical,
            "complete": self.complete,
            "again": len(self.again),
            "different": str(self.differences[0]) if self.differences else "",
        }


def file_results(
    found: Sequence[FileDifference], files: Mapping[str, str], unknown: Mapping[str, str]
) -> tuple[FileResult, ...]:
    """Return the result for each file: of those with a difference, 'differs'.

    Args:
        found: the differences.
        files: how each compared file was compared, by name.
        unknown: files, or why they cannot be known, by name.
    """
    listed, changed = {**files, **unknown}, {one.file for one in found}
    for file in sorted(changed):
        folder = f"{file.partition('/')[0]}/"
        if folder in listed:
            changed.add(folder)
        else:
            listed.setdefault(file, "")
    return tuple(
        FileResult(
            name,
            "differs" if name in changed else "cannot be known" if name in unknown else "same",
            text,
        )
        for name, text in listed.items()
    )


def verify_run(
    run: RunSnapshot,
    *,
    everything: bool | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda steps: None,
) -> Verdict:
    """Check that a run's files agree, then evolve it again and compare every generation.

    Args:
        run: run to verify; generations added during the verification are left out.
        everything: whether to evolve the whole run again, up to the first difference; None does so
            if it took at most `QUICK`. Otherwise, only the best individual of each generation, the
            last population and the members of a front or archive are evaluated again.
        workers: number of parallel workers; None for a number that deliberately differs from the
            run's default, as the result must not depend on it.
        begin: callback with the number of generations.
        advance: callback with the number of generations done since the last call.
    """
    last = run.finished.generation
    _ = run.previous, run.saves  # read and cached now, before the run grows
    found = [*_file_differences(run)]

    def new_evaluator(experiment: Experiment) -> Evaluator:
        return Evaluator(experiment, workers or (1 if experiment.organism.threads else 2))

    if everything is None:
        everything = float(run.history["seconds"].sum()) <= QUICK
    begin(last)
    again, farthest = 0, 0.0
    if everything:
        for generation in evolve_again(run, new_evaluator):
            again, recorded = generation.number, float(run.bests[generation.number - 1]["score"])
            score = float(generation.scores[generation.best])
            farthest = max(farthest, 0.0 if score == recorded else abs(score - recorded))
            advance(1)
            if wrong := _generation_differences(run, generation):
                found += wrong
                break
    else:
        found += _differences_of_evaluations(run, new_evaluator, advance)
    found.sort(key=lambda one: one.generation)
    origins = read_provenance(run.path)
    return Verdict(
        kind="run",
        parts="generations evolved",
        total=last,
        again=tuple(range(1, again + 1)),
        complete=again == last,
        differences=tuple(found),
        files=_results(run, found, again == last),
        notes=_notes(run, everything=everything),
        origins=tuple(origins),
        version_differences=tuple(differences(origins, current_versions(run.experiment_at(last)))),
        portability=run.portability,
        score_difference=farthest,
    )


def _notes(run: RunSnapshot, *, everything: bool) -> tuple[str, ...]:
    notes = [run.warning] if run.warning else []
    if not everything:
        notes.append(
            "only the best individual of each generation and the last population were evaluated "
            "again; a forger could have changed the rest: --all evolves it again"
        )
    return tuple(notes)


def _results(
    run: RunSnapshot, found: Sequence[FileDifference], complete: bool
) -> tuple[FileResult, ...]:
    """Return the result for each file of a run."""
    islands = [ISLANDS] if run.islands.shape[1] > 1 else []
    previous = [PREVIOUS] if run.previous is not None else []
    evolved = dict.fromkeys([HISTORY, *islands, ALL_SCORES, CHECKSUMS, *previous, CHECKPOINT], "")
    evolved[HISTORY] = "except for seconds"
    evolved[f"{CHAMPIONS}/"] = "as the threshold demands"
    if run.start is not None:
        evolved[START] = "generation 1 evolved from it"
    files = {
        EXPERIMENT: "except for texts and limits",
        BESTS: "" if complete else "scores and terms",
        SAVES: f"agrees with {CHECKPOINT}",
    }
    unknown = {PROVENANCE: "what it states of the past"}
    if os.path.lexists(run.path / MEASURES):
        stored = read_measured(run.path)
        if stored is not None and stored.generation > run.generation:
            unknown[MEASURES] = "of a generation that the run has lost; not used"
        else:
            files[MEASURES] = "the champion's motion, simulated again"
    if is_folder(run.path / ADAPTATIONS):
        unknown[f"{ADAPTATIONS}/"] = "verify each of its files"
    if complete:
        return file_results(found, files | evolved, unknown)
    agrees = dict.fromkeys(evolved, "agrees with the other files")
    return file_results(found, files, agrees | unknown)


# What follows from the files alone


def row_of(run: RunSnapshot, generation: int) -> dict[str, float]:
    """Return a generation's row of the history, by column name."""
    return {name: float(values[generation - 1]) for name, values in run.history.items()}


def expected_chain(run: RunSnapshot, generation: int) -> bytes:
    """Return the chain checksum of a generation, computed from the files of the run."""
    records = run.checksums
    before: bytes = records[generation - 2]["chain"].tobytes() if generation > 1 else NONE
    parts: bytes = records[generation - 1].tobytes()[: -len(NONE)]
    best: bytes = run.bests[generation - 1].tobytes()
    best += islands_record(run.islands[generation - 1]) + run.score_bytes(generation)
    return chain_checksum(before, parts, row_of(run, generation), best)


def wrong_checksums(run: RunSnapshot, generation: Generation) -> list[str]:
    """Return the parts, `genomes` or `scores`, of a generation that differ from their checksums."""
    record = run.checksums[generation.number - 1 : generation.number]
    if record.tobytes() in (b"", bytes(RECORD.itemsize)):
        return []  # lost; reported for its row
    parts = {
        "genomes": genomes_checksum(generation.genomes),
        "scores": scores_checksum(generation.evaluation),
    }
    return [part for part, found in parts.items() if record[part].tobytes() != found]


def _file_differences(run: RunSnapshot) -> Iterator[FileDifference]:
    """Yield the differences that follow from the files alone."""
    for text in run.damaged:
        named = [name for name in (CHECKPOINT, PREVIOUS) if name in text]
        yield FileDifference(min(named, key=text.index, default=CHECKPOINT), text)
    for change in run.pending:
        now, then = ("not set" if one is None else brief(one) for one in (change.now, change.then))
        yield FileDifference(
            EXPERIMENT,
            f"{change.key} is {now} in the file, {then} in the run: resuming would apply the "
            f"file's options, starting with generation {run.generation + 1}",
        )
    yield from _row_differences(run)
    if not is_locked(run.path) and not run.warning:
        yield from _end_differences(run)
    yield from _checkpoint_differences(run, run.finished, CHECKPOINT)
    if run.previous is not None:
        yield from _checkpoint_differences(run, run.previous, PREVIOUS)
    yield from _champion_differences(run)
    yield from _measure_differences(run)


def _measure_differences(run: RunSnapshot) -> Iterator[FileDifference]:
    """Simulate the champion again, and compare its measures with the stored ones.

    After a process was killed, they may be those of an earlier champion, or of a later one whose
    generation is lost; the latter are not used.
    """
    if not os.path.lexists(run.path / MEASURES):
        return
    stored = read_measured(run.path)
    if stored is None or stored.generation < 1:
        yield FileDifference(MEASURES, "is damaged")
    if stored is None or not 1 <= stored.generation <= run.generation:
        return
    now = Measured.of(run.individual(stored.generation))
    if repr(stored) != repr(now):  # NaN equals NaN
        names = [
            name
            for name in dict.fromkeys([*stored.measures, *now.measures])
            if repr(stored.measures.get(name)) != repr(now.measures.get(name))
        ]
        what = f"{', '.join(names)} differ" if names else "the score or the warnings differ"
        yield FileDifference(MEASURES, f"{what} when computed", stored.generation)


def _row_differences(run: RunSnapshot) -> Iterator[FileDifference]:
    """Compare history, bests and islands with each other and with their checksums."""
    for number, score in enumerate(run.bests["score"].tolist(), start=1):
        best = float(run.history["best"][number - 1])
        if best != score:
            yield FileDifference(HISTORY, f"best is {best!r}, {score!r} in {BESTS}", number)
        if number > len(run.checksums):
            yield FileDifference(CHECKSUMS, "the checksum is missing", number)
        elif run.checksums[number - 1]["chain"].tobytes() != expected_chain(run, number):
            text = f"does not fit {HISTORY}, {BESTS}, {ISLANDS} or {ALL_SCORES}"
            yield FileDifference(CHECKSUMS, text, number)


def _end_differences(run: RunSnapshot) -> Iterator[FileDifference]:
    """Tell records and checkpoints that were put there from those that a killed process left.

    A process that is killed while it saves leaves records of one save after the checkpoint.
    """
    last, saves = run.generation, run.saves
    if len(saves) and (np.diff(saves, prepend=0) <= 0).any():
        yield FileDifference(SAVES, "its generations do not increase", last)
    elif last not in saves:
        yield FileDifference(
            SAVES, f"lacks generation {last}, although {CHECKPOINT} is of it", last
        )
    elif (saves > last).sum() > 1:
        text = f"of generation {last}, but {saves[-2]} was saved later: an older one was put there"
        yield FileDifference(CHECKPOINT, text, last)
    unfinished = max(int(saves[-1]) - last, 0) if len(saves) else 0
    record = run.bests.dtype.itemsize
    most = {SAVES: len(saves) * SAVE.itemsize, BESTS: (last + unfinished) * record}
    most[CHECKSUMS] = (last + unfinished) * RECORD.itemsize
    most[ALL_SCORES] = max(block_ends(run.path / ALL_SCORES, last + unfinished), default=0)
    for name in (HISTORY, ISLANDS) if run.islands.shape[1] > 1 else (HISTORY,):
        ends = line_ends(run.path / name, last + unfinished)
        if len(ends) > last + unfinished:  # otherwise, the last row is not finished
            most[name] = ends[-1]
    for name, size in most.items():
        with suppress(OSError):
            left = os.stat(run.path / name).st_size - size  # noqa: PTH116
            if left > 0:
                text = f"{left:,} bytes at its end belong to no generation"
                yield FileDifference(name, text, last)


def _checkpoint_differences(
    run: RunSnapshot, checkpoint: Checkpoint, name: str
) -> Iterator[FileDifference]:
    """Compare a checkpoint with its checksums and the bounds of its genes."""
    number = checkpoint.generation
    for part in wrong_checksums(run, restore_generation(checkpoint)):
        yield FileDifference(name, f"the {part} do not match {CHECKSUMS}", number)
    for stage, ours in zip(checkpoint.stages, run.finished.stages, strict=False):
        if stage != ours:
            text = f"the stage that ends with generation {stage.generation} differs"
            yield FileDifference(name, text, number)
    if outside := out_of_bounds(run.experiment_at(number), checkpoint.genomes, "the population"):
        yield FileDifference(name, outside, number)


def _champion_differences(run: RunSnapshot) -> Iterator[FileDifference]:
    """Compare the kept champions with the other files."""
    for number in champion_generations(run.path, run.generation):
        name = champion_file(number)
        try:
            kept = read_champion(run.path / name)
        except CheckpointError as error:
            yield FileDifference(name, error.what, number)
            continue
        if kept.generation != number:
            yield FileDifference(name, f"of generation {kept.generation}", number)
            continue
        outline = read_outline(kept.experiment, name)
        for change in changes(run.stage_at(number).outline, outline):
            yield FileDifference(name, f"its experiment differs: {change}", number)
        best = run.bests[number - 1]
        if not np.array_equal(kept.genome, best["genome"]) or kept.score != best["score"]:
            yield FileDifference(name, f"its genome or score is not that in {BESTS}", number)
        if kept.terms != best_terms(run.history, number):
            yield FileDifference(name, f"its terms are not those in {HISTORY}", number)


def _record_differences(run: RunSnapshot, generation: Generation) -> Iterator[FileDifference]:
    """Yield how the row and the best record of a generation differ from the recorded ones."""
    number = generation.number
    then, now = row_of(run, number), row(generation)
    for name in {**then, **now}:
        one, other = then.get(name, np.nan), float(now.get(name, np.nan))
        if name != "seconds" and not np.array_equal(one, other, equal_nan=True):
            yield FileDifference(HISTORY, f"{name} is {one!r}, but {other!r} when computed", number)
    best, genome = run.bests[number - 1], generation.genomes[generation.best]
    score = float(generation.scores[generation.best])
    if best["score"] != score:
        text = f"the score is {float(best['score'])!r}, but {score!r} when computed"
        yield FileDifference(BESTS, text, number)
    for at in np.flatnonzero(best["genome"] != genome)[:1]:
        one, other = best["genome"][at].item(), genome[at].item()
        text = f"gene {at + 1} is {one!r}, but {other!r} when computed"
        yield FileDifference(BESTS, text, number)
    if run.score_bytes(number) != scores_of(generation.evaluation):
        yield FileDifference(ALL_SCORES, "a score or value differs when computed", number)
    if run.islands.shape[1] > 1:
        islands = island_bests(generation, run.islands.shape[1])
        for at in np.flatnonzero(run.islands[number - 1] != islands)[:1]:
            yield FileDifference(ISLANDS, f"the best score of island {at + 1} differs", number)


# Evolving and evaluating again


def evolve_again(
    run: RunSnapshot, new_evaluator: Callable[[Experiment], Evaluator]
) -> Iterator[Generation]:
    """Evolve a run again from its experiments, and yield its generations."""
    last: Generation | None = None
    for stage in run.stages:
        experiment = run.experiment_at(stage.last)
        limits = {"generations": stage.last, **LIMITS}  # the only stop condition
        experiment = replace(experiment, evolution=experiment.evolution.model_copy(update=limits))
        start = run.starts(experiment) if last is None else None
        with new_evaluator(experiment) as evaluator:
            if last is not None:
                last = begin_again(last, stage, experiment, evaluator.evaluate)
            places = island_map(evaluator)
            for again in evolve(experiment, evaluator.evaluate, last, start, places):
                yield again
                last = again


def _generation_differences(run: RunSnapshot, again: Generation) -> list[FileDifference]:
    """Return how a generation that was evolved again differs from the record.

    Genomes, scores and terms of checkpoints are compared with their checksums, and champions with
    the records.
    """
    number = again.number
    found = [
        FileDifference(CHECKSUMS, f"the {part} differ when evolved again", number)
        for part in wrong_checksums(run, again)
    ]
    found += _record_differences(run, again)
    champion = champion_file(number)
    if again.is_champion != os.path.lexists(run.path / champion):
        what = "is missing" if again.is_champion else "did not beat the threshold"
        found.append(FileDifference(champion, what, number))
    stored: dict[str, Checkpoint | None] = {CHECKPOINT: run.finished, PREVIOUS: run.previous}
    for name, one in stored.items():
        if one is not None and one.generation == number:
            then = restore_generation(one)
            wrong = _different_arrays(then.evaluation.values, again.evaluation.values)
            wrong += _different_arrays(then.state, again.state)
            progress = vars(again.progress)
            wrong += [
                part for part, value in vars(then.progress).items() if value != progress[part]
            ]
            if any(
                again.evaluation.reasons.get(at) != why
                for at, why in then.evaluation.reasons.items()
            ):
                wrong.append("reason of failure")
            found += [
                FileDifference(name, f"its {part.replace('_', ' ')} differs", number)
                for part in wrong
            ]
    return found


def _different_arrays(
    then: Mapping[str, NDArray[Any]], now: Mapping[str, NDArray[Any]]
) -> list[str]:
    """Return the names of the arrays that differ, or that only one of two mappings has."""
    return [
        name
        for name in sorted({*then, *now})
        if name not in then
        or name not in now
        or then[name].dtype != now[name].dtype
        or not np.array_equal(then[name], now[name], equal_nan=True)
    ]


def _differences_of_evaluations(
    run: RunSnapshot,
    new_evaluator: Callable[[Experiment], Evaluator],
    advance: Callable[[int], object],
) -> Iterator[FileDifference]:
    """Evaluate again the best individuals, the last population, and a front or archive."""
    for stage in run.stages:
        with new_evaluator(run.experiment_at(stage.last)) as evaluator:
            numbers = range(stage.first, stage.last + 1)
            for _, group in groupby(numbers, stage.outline.worlds.first_of_draw):
                same_worlds = [*group]
                for at in range(0, len(same_worlds), BATCH):
                    batch = same_worlds[at : at + BATCH]
                    yield from _differences_of_bests(run, batch, evaluator)
                    advance(len(batch))
            if stage.last < run.generation:
                continue
            last, members = run.finished, run.members
            if not out_of_bounds(evaluator.experiment, last.genomes, "the population"):
                then = {"score": last.scores, **last.terms, **last.values}
                for name, at in _wrong_values(evaluator, last.genomes, stage.last, then):
                    text = f"the {name} of individual {at} differs when evaluated again"
                    yield FileDifference(CHECKPOINT, text, stage.last)
            if members is not None and len(members.scores):
                then = {"score": members.scores, **members.values}
                for name, at in _wrong_values(evaluator, members.genomes, stage.last, then):
                    text = f"the {name} of member {at + 1} differs when evaluated again"
                    yield FileDifference(CHECKPOINT, text, stage.last)


def _differences_of_bests(
    run: RunSnapshot, numbers: Sequence[int], evaluator: Evaluator
) -> Iterator[FileDifference]:
    """Evaluate the best individuals of generations with the same worlds."""
    genomes = {}
    for number in numbers:
        try:
            genomes[number] = run.best_genome(number)
        except RunError as error:
            yield FileDifference(BESTS, error.what, number)
    if genomes:
        rows = np.array([*genomes]) - 1
        then = {name: run.history[name][rows] for name in terms_of(run.history)}
        then["score"] = run.bests["score"][rows]
        again = np.stack([*genomes.values()])
        for name, at in _wrong_values(evaluator, again, numbers[0], then):
            text = f"the {name} of the best individual differs when evaluated again"
            yield FileDifference(BESTS, text, [*genomes][at])


def _wrong_values(
    evaluator: Evaluator, genomes: Genomes, number: int, then: Mapping[str, NDArray[Any]]
) -> Iterator[tuple[str, int]]:
    """Yield the name and the index of each value that differs when genomes are evaluated again."""
    again = evaluator.evaluate(genomes, number)
    for name, values in {**again.terms, **again.values, "score": again.scores}.items():
        if name in then:
            for at in np.flatnonzero((then[name] != values) & ~np.isnan(values)):
                yield name, int(at)


def compare_folders(here: Path, there: Path) -> list[FileDifference]:
    """Compare the files in a folder that was computed again with those of the original.

    Args:
        here: the original, which is not trusted.
        there: the folder that was computed again.
    """
    found = []
    for file in sorted(path for path in there.rglob("*") if path.is_file()):
        name, data = file.relative_to(there).as_posix(), file.read_bytes()
        try:
            if read_regular(here / name, len(data)) != data:
                found.append(FileDifference(name, "differs when computed again"))
        except OSError as error:
            found.append(FileDifference(name, f"cannot be compared: {error.strerror}"))
    return found
