"""A run on disk, written generation by generation."""

import re
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from gaitsim.errors import GaitsimError, PluginError, RunError
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation, Progress, stop_reason
from gaitsim.experiment import Evolution, with_overrides
from gaitsim.runs import history
from gaitsim.runs.atomic import remove_partials, write_bytes, writing
from gaitsim.runs.checkpoint import Champion, Checkpoint, write_champion, write_checkpoint
from gaitsim.runs.folder import (
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    EXPERIMENT,
    HISTORY,
    PREVIOUS,
    command,
)
from gaitsim.runs.lock import RunLock
from gaitsim.runs.reader import Run, versions
from gaitsim.toml import parse

REASONS_KEPT = 1000
"""Of how many failed individuals a checkpoint says why."""


class RunWriter:
    """A run folder, opened for writing by this process alone; a context manager.

    Attributes:
        run: the same, for reading.
        experiment: as it goes on.
        last: the generation to go on from; None where none is finished.

    Raises:
        RunError: another process writes it, it is damaged, or was made with other
            versions of its plugins' packages.
    """

    def __init__(
        self, path: Path, *, generations: int | None = None, any_version: bool = False
    ) -> None:
        """Open the run in `path`; `generations` changes how far it is to go."""
        self.path = path
        with ExitStack() as held:
            held.callback(RunLock(path).release)
            remove_partials(path)
            self.run = Run(path)
            self.experiment = self.run.experiment
            self._warnings: list[str] = []
            self.last = self._restore(any_version)
            if generations is not None:
                self._extend(generations)
            self._layout = history.record_type(self.experiment.space())
            self._cut_back(held)
            self._held = held.pop_all()

    @property
    def warning(self) -> str:
        """What a user should know about how the run was found, or ''."""
        return "; ".join(self._warnings)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._held.close()

    def _restore(self, any_version: bool) -> Generation | None:
        found = self.run.checkpoint(keep_damaged=True)
        if found is None:
            return None
        checkpoint, warning = found
        if warning:
            self._warnings.append(warning)
        self._compare_versions(checkpoint, any_version)
        self.run.check_fit(checkpoint)
        changes = _changes(checkpoint.experiment, self.experiment.to_toml())
        if changes:
            self._warnings.append(
                f"{EXPERIMENT} was changed after generation {checkpoint.generation} "
                f"({', '.join(changes)}): the run goes on as it says now"
            )
        return restored(checkpoint)

    def _compare_versions(self, checkpoint: Checkpoint, any_version: bool) -> None:
        now = versions(self.experiment)
        changed = {
            name: f"{name}: {then} then, {now[name]} now"
            for name, then in checkpoint.versions.items()
            if name in now and now[name] != then
        }
        numpy = changed.pop("numpy", None)
        if changed and not any_version:
            raise RunError(
                f"the run {self.path} was made with other versions: " + "; ".join(changed.values()),
                remedy="install those versions, or go on with these by --any-version: "
                "the rest may then not be what it would have been",
            )
        if numpy:
            self._warnings.append(f"another version of {numpy}: the last bits may differ")

    def _extend(self, generations: int) -> None:
        done = self.last.number if self.last else 0
        if generations < done:
            raise RunError(
                f"the run {self.path} is at generation {done} already",
                allowed=f"--generations {done} or more",
                remedy=f"leave it, or begin a new one: {command('run', self.path / EXPERIMENT)}",
            )
        self.experiment = with_overrides(self.experiment, [f"evolution.generations={generations}"])
        write_bytes(self.path / EXPERIMENT, self.experiment.to_toml().encode())

    def _cut_back(self, held: ExitStack) -> None:
        """Open the growing files after the records that the checkpoint counts, drop the rest."""
        done = self.last.number if self.last else 0
        rows, bests = self.path / HISTORY, self.path / BESTS
        lines = history.line_ends(rows)
        if done and len(lines) < 1 + done:
            raise self.run.ends_early(HISTORY, max(len(lines) - 1, 0), done)
        stored = bests.stat().st_size // self._layout.itemsize if bests.exists() else 0
        if stored < done:
            raise self.run.ends_early(BESTS, stored, done)
        with writing(self.path):
            self._history = history.Growing(rows, lines[done] if done else 0)
            held.callback(self._history.close)
            self._bests = history.Growing(bests, done * self._layout.itemsize)
            held.callback(self._bests.close)
            for champion in (self.path / CHAMPIONS).glob("generation-*.pickle"):
                number = re.fullmatch(r"generation-(\d+)", champion.stem)
                if number and int(number[1]) > done:
                    champion.unlink()

    def record(self, generation: Generation) -> None:
        """Write a finished generation: history and best first, the checkpoint last.

        A process killed in between leaves records past the checkpoint; they are cut off
        when the run is resumed.

        Raises:
            RunError: it cannot be written; the run stands as of the generation before.
        """
        values = history.row(generation)
        if generation.number == 1:
            self._check_columns(values, generation)
        if not self.path.is_dir():
            raise RunError(
                f"the folder of the run {self.path} is gone",
                remedy="begin a new run, in a folder that stays",
            )
        best = generation.best
        record = np.zeros((), self._layout)
        record["score"], record["genome"] = generation.scores[best], generation.genomes[best]
        with writing(self.path):
            header = history.line(tuple(values)) if generation.number == 1 else ""
            self._history.append((header + history.line(values)).encode())
            self._bests.append(record.tobytes())
        if generation.is_champion:
            self._write_champion(generation)
        write_checkpoint(self.path / CHECKPOINT, self._checkpoint(generation), self.path / PREVIOUS)

    def _check_columns(self, values: dict[str, float], generation: Generation) -> None:
        """Refuse terms that are called as other columns of the history are."""
        if len(values) < len(history.COLUMNS) + 2 * len(generation.evaluation.terms):
            entry = self.experiment.entries["fitness"]
            raise PluginError(
                f"{entry} names a term as a column of the history is named",
                where=entry.target,
                allowed=f"other names than {', '.join(history.COLUMNS)}, and none that is another "
                f"term's after {history.MEAN!r}",
                remedy=f"update {entry.package}, or report it to its author",
            )

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
        write_champion(folder / f"generation-{generation.number:06d}.pickle", champion)

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
        )

    @cached_property
    def _versions(self) -> dict[str, str]:
        return versions(self.experiment)

    @cached_property
    def _toml(self) -> str:
        return self.experiment.to_toml()


def restored(checkpoint: Checkpoint) -> Generation:
    """The generation that a checkpoint holds."""
    reasons = {int(index): reason for index, reason in checkpoint.reasons.items()}
    return Generation(
        number=checkpoint.generation,
        genomes=checkpoint.genomes,
        evaluation=Evaluation(checkpoint.scores, checkpoint.terms, reasons),
        progress=Progress(
            evaluations=checkpoint.evaluations,
            best_score=checkpoint.best_score,
            stagnation=checkpoint.stagnation,
            threshold=checkpoint.threshold,
        ),
        diversity=float("nan"),
        seconds=0.0,
        is_champion=False,
        stop="",
    )


def is_finished(evolution: Evolution, checkpoint: Checkpoint) -> bool:
    """Whether a stop condition holds for the generation of a checkpoint."""
    generation = restored(checkpoint)
    return bool(stop_reason(evolution, generation.number, generation.progress))


def _changes(then: str, now: str) -> list[str]:
    """The options by which two experiments evolve differently, each as `rate: 0.1, now 0.2`."""
    before, after = _options(then), _options(now)
    return [
        f"{key}: {before.get(key, 'not set')}, now {after.get(key, 'not set')}"
        for key in sorted({*before, *after})
        if before.get(key) != after.get(key)
    ]


def _options(text: str) -> dict[str, Any]:
    """The options of an experiment that matter from one generation to the next."""
    try:
        tables = parse(text, "")
    except GaitsimError:
        return {}
    options = {
        f"{section}.{key}": value
        for section, table in tables.items()
        if isinstance(table, dict)
        for key, value in table.items()
    }
    options["seed"] = tables.get("seed")
    options.pop("evolution.generations", None)
    return options
