"""Check whether the files of a run are consistent."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gaitsim.errors import CheckpointError
from gaitsim.evolution import Generation, SearchProgress, advance
from gaitsim.evolution.searching import figures
from gaitsim.experiment import read_outline
from gaitsim.storage.compatibility import out_of_bounds
from gaitsim.storage.files.checkpoint import KEPT, Champion, Checkpoint
from gaitsim.storage.files.folder import (
    BESTS,
    CHECKPOINT,
    CHECKSUMS,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    kept_file,
    kept_generations,
)
from gaitsim.storage.files.history import best_terms, island_bests, islands_record, row
from gaitsim.storage.files.records import NONE, chain_checksum, genomes_checksum, scores_checksum
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import (
    Change,
    changes,
    first_comparable,
    next_progress,
    restore_generation,
)

SAVING_OPTIONS = ("fitness_threshold", "delta_fitness")
"""Options of [evolution] that start no stage, but decide which champions are saved."""


def row_of(run: RunSnapshot, generation: int) -> dict[str, float]:
    """Return a generation's row of the history, by column name."""
    return {name: float(values[generation - 1]) for name, values in run.history.items()}


def best_record(run: RunSnapshot, generation: int) -> bytes:
    """Return the records of a generation's best individual, as covered by its checksum."""
    record: bytes = run.bests[generation - 1].tobytes()
    return record + islands_record(run.islands[generation - 1])


def checksum(run: RunSnapshot, generation: int, part: str) -> bytes | None:
    """Return the recorded checksum of `genomes`, `scores` or `chain`; None if it is missing."""
    if not 1 <= generation <= len(run.checksums):
        return None
    found: bytes = run.checksums[generation - 1][part].tobytes()
    return None if found == NONE else found


def expected_chain(run: RunSnapshot, generation: int) -> bytes:
    """Return the chain checksum of a generation, computed from the files of the run."""
    before = checksum(run, generation - 1, "chain") or NONE
    parts = run.checksums[generation - 1].tobytes()[: -len(NONE)]
    return chain_checksum(before, parts, row_of(run, generation), best_record(run, generation))


def wrong_checksums(run: RunSnapshot, generation: Generation) -> list[str]:
    """Return the parts, `genomes` or `scores`, of a generation that differ from their checksums."""
    parts = {
        "genomes": genomes_checksum(generation.genomes),
        "scores": scores_checksum(generation.evaluation),
    }
    return [
        part
        for part, found in parts.items()
        if checksum(run, generation.number, part) not in (None, found)
    ]


def count_without_checksum(run: RunSnapshot) -> int:
    """Return the number of generations without a checksum."""
    if not len(run.checksums):
        return run.generation
    return run.generation - int((run.checksums["chain"] != np.void(NONE)).sum())


def edited_options(run: RunSnapshot) -> tuple[Change, ...]:
    """Return the differences between `experiment.toml` and the experiment of the last generation.

    Options that only affect when the search stops are left out.
    """
    if run.finished.experiment == run.experiment_text:
        return ()
    before, after = run.stages[-1].outline.evolution, run.experiment.evolution
    then, now = before.model_dump(), after.model_dump()
    saved = then["fitness_threshold"], now["fitness_threshold"]
    # Without a threshold, no champions are saved.
    keys = SAVING_OPTIONS if saved != (None, None) else ()
    changed = [Change(f"evolution.{key}", then[key], now[key]) for key in keys]
    return (*run.pending, *(change for change in changed if change.then != change.now))


def inconsistencies(run: RunSnapshot) -> dict[int, list[str]]:
    """Return the inconsistencies between the files of a run, by generation in order."""
    found: dict[int, list[str]] = {}
    for generation, what in (
        *_check_rows(run),
        *_check_checkpoint(run, run.finished, CHECKPOINT),
        *_check_checkpoint(run, run.previous, PREVIOUS),
        *_check_progress(run),
        *_check_kept(run),
    ):
        found.setdefault(generation, []).append(what)
    return dict(sorted(found.items()))


def _check_rows(run: RunSnapshot) -> Iterator[tuple[int, str]]:
    """Compare history and bests with each other and with their checksums."""
    files = (HISTORY, ISLANDS, BESTS) if run.islands.shape[1] > 1 else (HISTORY, BESTS)
    for at, score in enumerate(run.bests["score"].tolist()):
        generation = at + 1
        found = row_of(run, generation)
        if found["best"] != score:
            yield generation, f"best is {found['best']!r} in {HISTORY}, {score!r} in {BESTS}"
        islands = float(run.islands[at].max())
        if islands != score and run.islands.shape[1] > 1:
            yield generation, f"best is {islands!r} in {ISLANDS}, {score!r} in {BESTS}"
        if found["stage"] != run.stage_at(generation).number:
            stage = run.stage_at(generation).number
            yield generation, f"stage is {found['stage']:g} in {HISTORY}, {stage} in {CHECKPOINT}"
        chain = checksum(run, generation, "chain")
        if chain is not None and chain != expected_chain(run, generation):
            yield generation, f"its row or record of {', '.join(files)} or {CHECKSUMS} was changed"


def _check_checkpoint(
    run: RunSnapshot, checkpoint: Checkpoint | None, name: str
) -> Iterator[tuple[int, str]]:
    """Compare a checkpoint with its checksums, its row and its record."""
    if checkpoint is None:
        return
    generation = restore_generation(checkpoint)
    number = generation.number
    for part in wrong_checksums(run, generation):
        yield number, f"the {part} in {name} do not match {CHECKSUMS}"
    if outside := population_out_of_bounds(run, checkpoint):
        yield number, f"{outside} in {name}"
        return
    space = run.experiment_at(number).space()
    diversity = float(space.diversity(generation.genomes))
    reported = figures(run.experiment_at(number), generation.state)
    generation = replace(generation, diversity=diversity, figures=reported)
    for what in row_differences(run, generation, f"in {name}"):
        yield number, what


def population_out_of_bounds(run: RunSnapshot, checkpoint: Checkpoint) -> str:
    """Return which gene of a checkpoint's population is out of the body's bounds; '' if none."""
    experiment = run.experiment_at(checkpoint.generation)
    return out_of_bounds(experiment, checkpoint.genomes, "the population")


def _check_progress(run: RunSnapshot) -> Iterator[tuple[int, str]]:
    """Compare the progress of the search in the checkpoint with the history."""
    checkpoint, last = run.finished, run.generation
    scores = run.history["best"][first_comparable(run.stages) - 1 :]
    best = float(scores.max())
    if checkpoint.best_score != best:
        yield last, f"the best score is {checkpoint.best_score!r} in {CHECKPOINT}, not {best!r}"
    since = len(scores) - 1 - int(np.argmax(scores))
    if np.isfinite(best) and checkpoint.stagnation != since:
        yield last, f"{CHECKPOINT} has a stagnation of {checkpoint.stagnation}, not {since}"
    threshold = checkpoint.threshold
    if last > 1 and run.previous is None:
        # Any generation may have raised the threshold, but it is never below the option.
        least = run.stages[-1].outline.evolution.fitness_threshold
        if (threshold is None) != (least is None) or (threshold or 0.0) < (least or 0.0):
            yield last, f"the threshold is {threshold} in {CHECKPOINT}, below {least}"
    elif threshold != (expected := _threshold(run)):
        yield last, f"the threshold is {threshold} in {CHECKPOINT}, not {expected}"


def _threshold(run: RunSnapshot) -> float | None:
    """Return the threshold after the last generation, computed from the previous checkpoint."""
    evolution = run.stages[-1].outline.evolution
    before = SearchProgress(0, -np.inf, -1, evolution.fitness_threshold)
    if run.previous is not None:
        previous = read_outline(run.previous.experiment, PREVIOUS)
        before = next_progress(run.previous, evolution, changes(previous, run.stages[-1].outline))
    done, worlds = run.previous.generation if run.previous else 0, run.stages[-1].outline.worlds
    for number, best in enumerate(run.history["best"][done:].tolist(), start=done + 1):
        if worlds.redrawn(number):
            before = before.reset_scores(evolution.fitness_threshold, 0)
        before, _ = advance(before, best, len(run.finished.genomes), evolution)
    return before.threshold


def _check_kept(run: RunSnapshot) -> Iterator[tuple[int, str]]:
    """Compare the kept champions and populations with the other files."""
    for subfolder, read in KEPT.items():
        for generation in kept_generations(run.path, subfolder, run.generation):
            name = kept_file(subfolder, generation)
            try:
                kept = read(run.path / name)
            except CheckpointError as error:
                yield generation, error.what
                continue
            if kept.generation != generation:
                yield generation, f"{name} is of generation {kept.generation}"
            elif isinstance(kept, Champion):
                yield from _check_champion(run, kept, name)
            else:
                yield from _check_checkpoint(run, kept, name)


def _check_champion(run: RunSnapshot, champion: Champion, name: str) -> Iterator[tuple[int, str]]:
    """Compare a champion with its record and its row."""
    generation, best = champion.generation, run.bests[champion.generation - 1]
    if not np.array_equal(champion.genome, best["genome"]):
        yield generation, f"the genomes in {name} and {BESTS} differ"
    if champion.score != best["score"]:
        yield generation, f"the scores in {name} and {BESTS} differ"
    if champion.terms != best_terms(run.history, generation):
        yield generation, f"the terms in {name} and {HISTORY} differ"


def row_differences(run: RunSnapshot, generation: Generation, place: str) -> list[str]:
    """Return how a generation's row and best record differ from the recorded ones.

    `place` ends each sentence, such as 'when reproduced'.
    """
    number = generation.number
    then, now = row_of(run, number), row(generation)
    found = [
        f"{HISTORY}: {name} is {value!r}, but {float(now.get(name, np.nan))!r} {place}"
        for name, value in then.items()
        if name != "seconds" and not np.array_equal(value, now.get(name, np.nan), equal_nan=True)
    ]
    found += [f"{HISTORY} lacks the column {name}" for name in now if name not in then]
    best, genome = run.bests[number - 1], generation.genomes[generation.best]
    score = float(generation.scores[generation.best])
    if best["score"] != score:
        found.append(f"{BESTS}: the score is {float(best['score'])!r}, but {score!r} {place}")
    islands = island_bests(generation, run.islands.shape[1])
    wrong = np.flatnonzero(run.islands[number - 1] != islands)
    if len(wrong) and len(islands) > 1:
        found.append(f"{ISLANDS}: the best score of island {wrong[0] + 1} differs {place}")
    for at in np.flatnonzero(best["genome"] != genome)[:1]:
        then_gene, gene = best["genome"][at].item(), genome[at].item()
        found.append(f"{BESTS}: gene {at + 1} is {then_gene!r}, but {gene!r} {place}")
    return found
