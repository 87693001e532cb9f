"""Check whether the files of a run are consistent."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gaitsim.errors import CheckpointError
from gaitsim.evolution import Generation, SearchProgress, advance
from gaitsim.evolution.searching import figures, finished
from gaitsim.experiment import read_outline
from gaitsim.storage.compatibility import out_of_bounds
from gaitsim.storage.files.checkpoint import KEPT, Champion, Checkpoint
from gaitsim.storage.files.folder import (
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    CHECKSUMS,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    SAVES,
    kept_file,
    kept_generations,
)
from gaitsim.storage.files.history import best_terms, island_bests, islands_record, row
from gaitsim.storage.files.records import NONE, chain_checksum, genomes_checksum, scores_checksum
from gaitsim.storage.lock import is_locked
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import begin_stage, changes, restore_generation


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


def inconsistencies(run: RunSnapshot) -> dict[int, list[str]]:
    """Return the inconsistencies between the files of a run, by generation in order."""
    progress = [*expected_progress(run)]
    found: dict[int, list[str]] = {}
    for generation, what in (
        *_check_rows(run),
        *_check_saves(run),
        *_check_progress(run, progress),
        *_check_checkpoint(run, run.finished, CHECKPOINT, progress),
        *_check_checkpoint(run, run.previous, PREVIOUS, progress),
        *_check_kept(run, progress),
    ):
        found.setdefault(generation, []).append(what)
    return dict(sorted(found.items()))


class Progress(NamedTuple):
    """The progress after a generation.

    Attributes:
        search: progress of the search.
        is_champion: whether the best individual of the generation is a champion.
        rescored: whether the scores are not comparable with those before, so that a search may
            have re-evaluated the individuals it remembers.
    """

    search: SearchProgress
    is_champion: bool
    rescored: bool


def expected_progress(run: RunSnapshot) -> Iterator[Progress]:
    """Yield the progress that follows from best scores and options, for each generation.

    Only the number of evaluations is taken from the history, as a search may re-evaluate the
    individuals it remembers, and `finished` is '', as it depends on the state of the search.
    """
    population = len(run.finished.genomes)
    evaluations = run.history["evaluations"].astype(np.int64).tolist()
    scores = run.bests["score"].tolist()
    first = run.stages[0].outline.evolution.fitness_threshold
    progress = SearchProgress(0, -np.inf, -1, first)
    for stage in run.stages:
        outline = stage.outline
        evolution, worlds = outline.evolution, outline.worlds
        if stage.changes:
            progress = begin_stage(progress, evolution, stage.changes, population)
        redrawn = {*worlds.redraws(stage.first, stage.last)}
        for number in range(stage.first, stage.last + 1):
            if number in redrawn:
                progress = progress.reset_scores(evolution.fitness_threshold, 0)
            progress, is_champion = advance(progress, scores[number - 1], 0, evolution)
            progress = replace(progress, evaluations=evaluations[number - 1])
            rescored = number in redrawn or (number == stage.first and stage.reevaluated)
            yield Progress(progress, is_champion, rescored)


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
        if chain is None:
            yield generation, f"its checksum in {CHECKSUMS} is missing"
        elif chain != expected_chain(run, generation):
            yield generation, f"its row or record of {', '.join(files)} or {CHECKSUMS} was changed"


def _check_saves(run: RunSnapshot) -> Iterator[tuple[int, str]]:
    """Tell a checkpoint that was put there from one that a killed process left behind.

    A process that is killed while it saves leaves records of one save after the checkpoint.
    """
    last, saves = run.generation, run.saves
    if len(saves) and (np.diff(saves, prepend=0) <= 0).any():
        yield last, f"{SAVES} was changed: its generations do not increase"
    elif last not in saves:
        yield last, f"{SAVES} does not list generation {last}, although {CHECKPOINT} is of it"
    elif not run.warning and not is_locked(run.path) and (saves > last).sum() > 1:
        yield (
            last,
            f"{CHECKPOINT} is of generation {last}, but generation {saves[-2]} was saved later: "
            "it was replaced by an older one",
        )


def _check_checkpoint(
    run: RunSnapshot, checkpoint: Checkpoint | None, name: str, progress: list[Progress]
) -> Iterator[tuple[int, str]]:
    """Compare a checkpoint with its checksums, its row, its record and the progress."""
    if checkpoint is None:
        return
    generation = restore_generation(checkpoint)
    number = generation.number
    for part in wrong_checksums(run, generation):
        yield number, f"the {part} in {name} do not match {CHECKSUMS}"
    experiment = run.experiment_at(number)
    expected = replace(progress[number - 1].search, finished=finished(experiment, generation.state))
    for part, value in vars(expected).items():
        if (there := getattr(generation.progress, part)) != value:
            yield number, f"{name}: {part.replace('_', ' ')} is {there!r}, not {value!r}"
    for stage, ours in zip(checkpoint.stages, run.finished.stages, strict=False):
        if stage != ours:
            yield number, f"{name}: the stage that ends with generation {stage.generation} differs"
    if outside := population_out_of_bounds(run, checkpoint):
        yield number, f"{outside} in {name}"
        return
    diversity = float(experiment.space().diversity(generation.genomes))
    reported = figures(experiment, generation.state)
    generation = replace(generation, diversity=diversity, figures=reported)
    for what in row_differences(run, generation, f"in {name}"):
        yield number, what


def population_out_of_bounds(run: RunSnapshot, checkpoint: Checkpoint) -> str:
    """Return which gene of a checkpoint's population is out of the body's bounds; '' if none."""
    experiment = run.experiment_at(checkpoint.generation)
    return out_of_bounds(experiment, checkpoint.genomes, "the population")


def _check_progress(run: RunSnapshot, progress: list[Progress]) -> Iterator[tuple[int, str]]:
    """Compare the number of evaluations and the saved champions with the expected ones."""
    population, before = len(run.finished.genomes), 0
    for number, found in enumerate(progress, start=1):
        evaluated, before = found.search.evaluations - before, found.search.evaluations
        if evaluated < population or (evaluated > population and not found.rescored):
            yield number, f"{HISTORY}: {evaluated} evaluations, but {population} individuals"
    champions = {number for number, found in enumerate(progress, start=1) if found.is_champion}
    kept = {*kept_generations(run.path, CHAMPIONS, run.generation)}
    for number in sorted(champions - kept):
        yield number, f"{kept_file(CHAMPIONS, number)} is missing, although it beat the threshold"
    for number in sorted(kept - champions):
        yield number, f"{kept_file(CHAMPIONS, number)} did not beat the threshold"


def _check_kept(run: RunSnapshot, progress: list[Progress]) -> Iterator[tuple[int, str]]:
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
                continue
            experiment = read_outline(kept.experiment, name)
            for change in changes(run.stage_at(generation).outline, experiment):
                yield generation, f"the experiment in {name} differs: {change}"
            if isinstance(kept, Champion):
                yield from _check_champion(run, kept, name)
            else:
                yield from _check_checkpoint(run, kept, name, progress)


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
