"""All that a run keeps of its generations, and whether it agrees with itself."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import CheckpointError
from gaitsim.evolution import Generation
from gaitsim.experiment import Evolution, Experiment
from gaitsim.runs.files.checkpoint import Champion, Checkpoint, read_champion, read_checkpoint
from gaitsim.runs.files.checksums import NONE, of_genomes, of_row, of_scores, read_digests
from gaitsim.runs.files.folder import (
    BESTS,
    CHECKPOINT,
    DIGESTS,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    champion_file,
    kept_champions,
)
from gaitsim.runs.files.history import best_terms, island_bests, islands_record, row
from gaitsim.runs.reader import Run
from gaitsim.runs.resume import restored
from gaitsim.runs.stages import Change, RunStage, comparable, pending, stages_of
from gaitsim.toml import parse

KEEPING = ("fitness_threshold", "delta_fitness")
"""Options of [evolution] that begin no stage, yet say which champions are kept."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """What a run's files say, read at one moment; generation g stands at index g − 1.

    Attributes:
        run: whose they are.
        checkpoint: the latest whole one.
        previous: of the generation before it; None where there is none to be read.
        stages: of the run.
        columns: of the history.
        bests: each generation's best.
        islands: the best score of each island, (generations, islands).
        digests: each generation's; fewer where the last ones were lost, none in old runs.
        warning: what a user should know about how the run was found, or ''.
        damaged: checkpoints that cannot be read, a text each: which, and why.
    """

    run: Run
    checkpoint: Checkpoint
    previous: Checkpoint | None
    stages: tuple[RunStage, ...]
    columns: Mapping[str, NDArray[np.float64]]
    bests: NDArray[Any]
    islands: NDArray[np.float64]
    digests: NDArray[Any]
    warning: str
    damaged: tuple[str, ...]

    @classmethod
    def of(cls, run: Run) -> "Recorded":
        """Read a run, which may grow meanwhile.

        Raises:
            RunError: no generation is finished, no checkpoint is whole, or a file is damaged
                otherwise or may not be read.
        """
        found = run.checkpoint()
        if found is None:
            raise run.unfinished()
        checkpoint, warning = found
        # A writer always leaves one of that name, so one that is missing was taken away.
        damaged = [warning] if warning else []
        last = checkpoint.generation
        previous: Checkpoint | None = None
        before = run.path / PREVIOUS
        if before.exists():  # not in a run of one generation, nor in a copy by `gaitsim fork`
            try:
                previous = read_checkpoint(before)
            except CheckpointError as error:
                damaged.append(error.what)
        if previous is not None and previous.generation != last - 1:
            previous = None
        columns = {name: values[:last] for name, values in run.history.items()}
        return cls(
            run,
            checkpoint,
            previous,
            stages_of(checkpoint),
            columns,
            run.bests[:last],
            run.islands[:last],
            read_digests(run.path / DIGESTS)[:last],
            warning or "",
            tuple(damaged),
        )

    @property
    def last(self) -> int:
        """The number of the last generation."""
        return self.checkpoint.generation

    def stage(self, generation: int) -> RunStage:
        """The stage that a generation belongs to."""
        return next(stage for stage in self.stages if generation <= stage.last)

    def experiment(self, generation: int) -> Experiment:
        """The experiment of a generation, its plugins loaded.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
        """
        return self.run.experiment_at(generation)

    def row(self, generation: int) -> dict[str, float]:
        """A generation's row of the history, by column."""
        return dict(zip(self.columns, self._rows[generation - 1], strict=True))

    @cached_property
    def _rows(self) -> list[list[float]]:
        rows: list[list[float]] = np.stack([*self.columns.values()], axis=1).tolist()
        return rows

    def digest(self, generation: int, part: str) -> bytes | None:
        """A digest of a generation: of its `genomes`, its `scores` or its `row`; None for none."""
        if generation > len(self.digests):
            return None
        found: bytes = self.digests[generation - 1][part].tobytes()
        return None if found == NONE else found

    @property
    def undigested(self) -> int:
        """How many generations have no digest."""
        if not len(self.digests):
            return self.last
        return self.last - int((self.digests["row"] != np.void(NONE)).sum())

    def kept(self, generation: int) -> bytes:
        """The records of a generation's best, as its digest counts them."""
        record: bytes = self.bests[generation - 1].tobytes()
        return record + islands_record(self.islands[generation - 1])

    @cached_property
    def asked_otherwise(self) -> tuple[Change, ...]:
        """By what `experiment.toml` differs from the experiment of the last generation.

        Options that only say how long the search goes are left out.

        Raises:
            ExperimentError: the file has problems.
        """
        made = self.checkpoint.experiment
        if made == self.run.experiment_text:
            return ()
        experiment = self.run.experiment
        return (*pending(self.checkpoint, experiment), *_keeping(made, experiment))

    @cached_property
    def champions(self) -> dict[int, Champion | CheckpointError]:
        """The kept champions by generation; the error of one that cannot be read."""
        found: dict[int, Champion | CheckpointError] = {}
        for generation in kept_champions(self.run.path):
            try:
                if generation <= self.last:
                    found[generation] = read_champion(self.run.path / champion_file(generation))
            except CheckpointError as error:
                found[generation] = error
        return found


def _keeping(made: str, experiment: Experiment) -> tuple[Change, ...]:
    """By what other champions would be kept than by the experiment `made`, in TOML."""
    then = Evolution().model_dump() | parse(made, "the checkpoint").get("evolution", {})
    now = experiment.evolution.model_dump()
    if then["fitness_threshold"] is None and now["fitness_threshold"] is None:
        return ()  # none are kept, by whatever step
    return tuple(
        Change(f"evolution.{key}", then[key], now[key]) for key in KEEPING if then[key] != now[key]
    )


def disagreements(recorded: Recorded) -> dict[int, list[str]]:
    """Where the files of a run disagree with one another, by generation in order.

    Raises:
        GaitsimError: an experiment of it has problems, or its body fails.
    """
    found: dict[int, list[str]] = {}
    for generation, what in (
        *_of_rows(recorded),
        *_of_checkpoint(recorded, recorded.checkpoint, CHECKPOINT),
        *_of_checkpoint(recorded, recorded.previous, PREVIOUS),
        *_of_progress(recorded),
        *_of_champions(recorded),
    ):
        found.setdefault(generation, []).append(what)
    return dict(sorted(found.items()))


def _of_rows(recorded: Recorded) -> Iterator[tuple[int, str]]:
    """History and bests, with one another and with their digests."""
    for at, score in enumerate(recorded.bests["score"].tolist()):
        generation = at + 1
        found = recorded.row(generation)
        if found["best"] != score:
            yield generation, f"best is {found['best']!r} in {HISTORY}, {score!r} in {BESTS}"
        islands = float(recorded.islands[at].max())
        if islands != score and recorded.islands.shape[1] > 1:
            yield generation, f"best is {islands!r} in {ISLANDS}, {score!r} in {BESTS}"
        if found["stage"] != recorded.stage(generation).number:
            yield generation, f"stage is {found['stage']:g} in {HISTORY} alone"
        digest = recorded.digest(generation, "row")
        if digest is not None and digest != of_row(found, recorded.kept(generation)):
            yield (
                generation,
                f"its row of {HISTORY} or its record of {BESTS} was changed",
            )


def _of_checkpoint(
    recorded: Recorded, checkpoint: Checkpoint | None, name: str
) -> Iterator[tuple[int, str]]:
    """A checkpoint with its digests, its row and its record."""
    if checkpoint is None:
        return
    generation = restored(checkpoint)
    number = generation.number
    for part, digest in (
        ("genomes", of_genomes(generation.genomes)),
        ("scores", of_scores(generation.evaluation)),
    ):
        if recorded.digest(number, part) not in (None, digest):
            yield number, f"the {part} in {name} are not those that {DIGESTS} tells of"
    space = recorded.experiment(number).space()
    diversity = float(space.diversity(generation.genomes))
    for what in row_differences(recorded, replace(generation, diversity=diversity)):
        yield number, f"{what} by {name}"


def _of_progress(recorded: Recorded) -> Iterator[tuple[int, str]]:
    """How far the checkpoint says that the search is, with the history."""
    checkpoint, last = recorded.checkpoint, recorded.last
    course = recorded.columns["best"][comparable(recorded.stages) - 1 :]
    best = float(course.max())
    if checkpoint.best_score != best:
        yield last, f"the best score is {checkpoint.best_score!r} in {CHECKPOINT}, not {best!r}"
    since = len(course) - 1 - int(np.argmax(course))
    if np.isfinite(best) and checkpoint.stagnation != since:
        yield last, f"{CHECKPOINT} counts {checkpoint.stagnation} generations since, not {since}"


def _of_champions(recorded: Recorded) -> Iterator[tuple[int, str]]:
    """The champions with the bests and the history."""
    for generation, champion in recorded.champions.items():
        name = champion_file(generation)
        if isinstance(champion, CheckpointError):
            yield generation, champion.what
            continue
        best = recorded.bests[generation - 1]
        if champion.generation != generation:
            yield generation, f"{name} says that it is of generation {champion.generation}"
        if not np.array_equal(champion.genome, best["genome"]):
            yield generation, f"the genome in {name} is not that in {BESTS}"
        if champion.score != best["score"]:
            yield generation, f"the score in {name} is not that in {BESTS}"
        if champion.terms != best_terms(recorded.columns, generation):
            yield generation, f"the terms in {name} are not those in {HISTORY}"


def row_differences(recorded: Recorded, generation: Generation) -> list[str]:
    """What a generation's row and best record are not as recorded, a text each."""
    number = generation.number
    then, now = recorded.row(number), row(generation)
    found = [
        f"{HISTORY}: {name} is {then[name]!r}, but {float(now.get(name, np.nan))!r}"
        for name in then
        if name != "seconds" and not _same(then[name], now.get(name, np.nan))
    ]
    found += [f"{HISTORY} lacks the column {name}" for name in now if name not in then]
    best, genome = recorded.bests[number - 1], generation.genomes[generation.best]
    score = float(generation.scores[generation.best])
    if best["score"] != score:
        found.append(f"{BESTS}: the score is {float(best['score'])!r}, but {score!r}")
    islands = island_bests(generation, recorded.islands.shape[1])
    wrong = np.flatnonzero(recorded.islands[number - 1] != islands)
    if len(wrong) and len(islands) > 1:
        found.append(f"{ISLANDS}: the best score of island {wrong[0] + 1} is another")
    genes = np.flatnonzero(best["genome"] != genome)
    if len(genes):
        at = genes[0]
        found.append(
            f"{BESTS}: gene {at + 1} is {best['genome'][at].item()!r}, but {genome[at].item()!r}"
        )
    return found


def _same(one: float, other: float) -> bool:
    return one == other or (math.isnan(one) and math.isnan(other))
