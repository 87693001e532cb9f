"""A run on disk, written generation by generation."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation, ParallelMap, evolve, stop_reason
from gaitsim.experiment import Overrides
from gaitsim.registry.plugin_context import contract_error
from gaitsim.runs.compatibility import versions
from gaitsim.runs.files import history
from gaitsim.runs.files import provenance as origins
from gaitsim.runs.files.append_only import (
    Growing,
    GrowingHistory,
    GrowingIslands,
    padded,
)
from gaitsim.runs.files.atomic import remove_partials, writing
from gaitsim.runs.files.checkpoint import Champion, Checkpoint, write_champion, write_checkpoint
from gaitsim.runs.files.checksums import RECORD, digests
from gaitsim.runs.files.folder import (
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    DIGESTS,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    champion_file,
    ends_early,
    kept_champions,
)
from gaitsim.runs.files.lock import RunLock
from gaitsim.runs.resume import open_run
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.stages import Change

REASONS_KEPT = 1000
"""Of how many failed individuals a checkpoint says why."""


class RunWriter:
    """A run folder, opened for writing by this process alone; a context manager.

    Attributes:
        run: the run as it was opened.
        experiment: as it goes on.
        last: the generation to go on from; None where none is finished.
        changes: of the experiment, by which a stage begins; () where none does.
        stage: number of the stage that goes on or begins, from 1.
        warning: what a user should know about how the run was found, or ''.

    Raises:
        RunError: another process writes it, it is damaged, was made with other versions
            of its plugins' packages, or would not go on under what is asked.
        ExperimentError: the experiment has problems, or what is asked does not fit the
            run; nothing is changed then.
    """

    def __init__(
        self,
        path: Path,
        *,
        overrides: Overrides | None = None,
        generations: int | None = None,
        any_version: bool = False,
    ) -> None:
        """Open the run in `path`.

        Args:
            path: its folder.
            overrides: options to change from here on, by key.
            generations: how far it is to go; None as far as planned.
            any_version: go on although a package has another version now.
        """
        self.path = path
        with ExitStack() as held:
            held.callback(RunLock(path).release)
            remove_partials(path)
            self.run = RunSnapshot(path, keep_damaged=True)
            opening = open_run(
                self.run, overrides, generations=generations, any_version=any_version
            )
            self.experiment, self.last = opening.experiment, opening.last
            self.changes: tuple[Change, ...] = opening.changes
            self.stage = len(opening.stages) + 1
            self.warning = "; ".join(opening.warnings)
            self._start, self._stages = opening.start, opening.stages
            self._unscored = opening.reevaluates
            self._noted = False
            self._layout = history.record_type(self.experiment.space())
            self._cut_back(held)
            self._held = held.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()

    def _cut_back(self, held: ExitStack) -> None:
        """Open the growing files after the records that the checkpoint counts, drop the rest."""
        done = self.last.number if self.last else 0
        rows, bests = self.path / HISTORY, self.path / BESTS
        lines = history.line_ends(rows)
        if done and len(lines) < 1 + done:
            raise ends_early(self.path, HISTORY, max(len(lines) - 1, 0), done)
        number = self.experiment.islands.number
        islands = self.path / ISLANDS
        bests_by_island = history.line_ends(islands) if number > 1 else []
        if number > 1 and done and len(bests_by_island) < 1 + done:
            raise ends_early(self.path, ISLANDS, max(len(bests_by_island) - 1, 0), done)
        stored = bests.stat().st_size // self._layout.itemsize if bests.exists() else 0
        if stored < done:
            raise ends_early(self.path, BESTS, stored, done)
        with writing(self.path):
            self._history = GrowingHistory(rows, lines[: done + 1] if done else [])
            held.callback(self._history.close)
            self._bests = Growing(bests, done * self._layout.itemsize)
            held.callback(self._bests.close)
            kept = bests_by_island[: done + 1] if done else []
            self._islands = GrowingIslands(islands, number, kept)
            held.callback(self._islands.close)
            self._digests = padded(self.path / DIGESTS, done, RECORD.itemsize)
            held.callback(self._digests.close)
            for number in kept_champions(self.path):
                if number > done:
                    (self.path / champion_file(number)).unlink(missing_ok=True)

    @property
    def done(self) -> str:
        """Why no generation is to be evolved any more, or ''."""
        last = self.last
        if last is None:
            return ""
        evolution = self.experiment.evolution
        return stop_reason(evolution, last.number, last.progress, len(last.genomes))

    @property
    def reevaluates(self) -> bool:
        """Whether a stage begins for which the population has yet to be judged anew."""
        return self._unscored

    def begin(self, evaluate: Callable[[Genomes], Evaluation]) -> None:
        """Begin the stage, if one begins: re-evaluate the population if its scores changed.

        Writes nothing. Done twice, it does no more than once.

        Args:
            evaluate: scores a population under `experiment`.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
        """
        if self._unscored and self.last is not None:
            self.last = self.last.reevaluated(evaluate, self.last.progress)
        self._unscored = False

    def evolve(
        self, evaluate: Callable[[Genomes], Evaluation], parallel_map: ParallelMap | None = None
    ) -> Iterator[Generation]:
        """Evolve from here; a generation that is yielded is on the disk.

        Args:
            evaluate: scores a population under `experiment`.
            parallel_map: evolves islands over workers; None evolves them here.

        Raises:
            PluginError: a plugin fails or breaks its contract; names its package.
            RunError: a generation cannot be written.
        """
        self.begin(evaluate)
        for generation in evolve(self.experiment, evaluate, self.last, self._start, parallel_map):
            self.record(generation)
            yield generation

    def record(self, generation: Generation) -> None:
        """Write a finished generation: history and best first, the checkpoint last.

        A process killed in between leaves records past the checkpoint; they are cut off
        when the run is resumed.

        Raises:
            RunError: it cannot be written; the run stands as of the generation before.
        """
        if self._unscored:
            raise ValueError("a stage begins with begin()")
        values = history.row(generation)
        terms = generation.evaluation.terms
        for name in terms:
            if name in history.COLUMNS or name.startswith(history.MEAN):
                what = f"names a term {name!r}, which is a column of the history"
                allowed = f"other names than {', '.join(history.COLUMNS)}"
                raise contract_error(self.experiment.entries["fitness"], what, allowed)
        if not self.path.is_dir():
            raise RunError(
                f"the folder of the run {self.path} is gone",
                remedy="begin a new run, in a folder that stays",
            )
        best = generation.best
        record = np.zeros((), self._layout)
        record["score"], record["genome"] = generation.scores[best], generation.genomes[best]
        islands = history.island_bests(generation, self.experiment.islands.number)
        kept = record.tobytes() + history.islands_record(islands)
        with writing(self.path):
            self._history.append(values)
            self._bests.append(record.tobytes())
            self._islands.append(generation.number, islands)
            # Not forced to disk, which takes as long as all else here: one that a power cut
            # takes away is only missed by who verifies the run.
            self._digests.append(
                digests(generation.genomes, generation.evaluation, values, kept),
                force=False,
            )
        self._note_origin(generation.number)
        if generation.is_champion:
            self._write_champion(generation)
        write_checkpoint(self.path / CHECKPOINT, self._checkpoint(generation), self.path / PREVIOUS)

    def _note_origin(self, first: int) -> None:
        """Write down what this process makes generations with, at its first one."""
        if not self._noted:
            origins.write_origin(self.path, first, origins.here(self.experiment))
            self._noted = True

    def _write_champion(self, generation: Generation) -> None:
        best = generation.best
        terms = generation.evaluation.terms
        champion = Champion(
            experiment=self._toml,
            versions=self._versions,
            generation=generation.number,
            genome=generation.genomes[best],
            score=float(generation.scores[best]),
            terms={name: float(values[best]) for name, values in terms.items()},
        )
        folder = self.path / CHAMPIONS
        with writing(folder):
            folder.mkdir(exist_ok=True)
        write_champion(self.path / champion_file(generation.number), champion)

    def _checkpoint(self, generation: Generation) -> Checkpoint:
        evaluation, progress = generation.evaluation, generation.progress
        reasons = list(evaluation.reasons.items())[:REASONS_KEPT]
        return Checkpoint(
            experiment=self._toml,
            versions=self._versions,
            generation=generation.number,
            evaluations=progress.evaluations,
            genomes=generation.genomes,
            scores=evaluation.scores,
            terms=evaluation.terms,
            reasons={str(index): reason for index, reason in reasons},
            stagnation=progress.stagnation,
            best_score=progress.best_score,
            threshold=progress.threshold,
            stages=self._stages,
        )

    @cached_property
    def _versions(self) -> dict[str, str]:
        return versions(self.experiment)

    @cached_property
    def _toml(self) -> str:
        return self.experiment.to_toml()
