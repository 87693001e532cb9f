"""A run on disk: made, written generation by generation, read back."""

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import CheckpointError, RunError
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation, Progress
from gaitsim.experiment import Experiment, parse_experiment, with_overrides
from gaitsim.runs import history
from gaitsim.runs.atomic import remove_partials, write_bytes
from gaitsim.runs.checkpoint import (
    Champion,
    Checkpoint,
    read_with_fallback,
    write_champion,
    write_checkpoint,
)
from gaitsim.runs.lock import RunLock

RUNS = Path("runs")
EXPERIMENT = "experiment.toml"
CHECKPOINT, PREVIOUS = "population.pickle", "population.previous.pickle"
HISTORY, BESTS = "history.csv", "bests.bin"
CHAMPIONS, EXPORTS = "champions", "exports"


def versions(experiment: Experiment) -> dict[str, str]:
    """What a run depends on: gaitsim, NumPy, and the package of each plugin."""
    found = {"gaitsim": version("gaitsim"), "numpy": np.__version__}
    for kind, entry in experiment.entries.items():
        found[f"{kind} {entry.name}"] = f"{entry.package} {entry.version}"
    return found


def find_run(reference: str) -> Path:
    """The folder of a run, given as a path or as a name under `runs/`.

    Raises:
        RunError: there is none.
    """
    for path in (Path(reference), RUNS / reference):
        if (path / EXPERIMENT).is_file():
            return path
    path = Path(reference)
    if path.is_dir() or (RUNS / reference).is_dir():
        raise RunError(
            f"{reference} is not a run: it holds no {EXPERIMENT}",
            remedy="'gaitsim runs' lists the runs here",
        )
    known = [run.name for run in list_runs(RUNS)]
    raise RunError(
        f"there is no run {reference!r}",
        allowed=", ".join(known) or f"no run is in {RUNS}/ of this folder yet",
        remedy="give a run's name or the path of its folder; 'gaitsim runs' lists them",
    )


def list_runs(root: Path) -> list[Path]:
    """The run folders under `root`, oldest first."""
    try:
        found = [path.parent for path in root.glob(f"*/{EXPERIMENT}")]
        return sorted(found, key=lambda path: ((path / EXPERIMENT).stat().st_mtime, path.name))
    except OSError as error:
        raise RunError(f"cannot list {root}: {error.strerror}") from None


def create_run(experiment: Experiment, out: Path | None = None) -> Path:
    """Make the folder of a new run; a name that is taken gets a number: spider-2.

    The folder appears at one stroke, with its experiment in it.

    Args:
        experiment: written to it, resolved.
        out: the folder to make; None is `runs/<name of the experiment>`.

    Raises:
        RunError: it cannot be made.
    """
    wanted = RUNS / experiment.name if out is None else out
    with _writing(wanted):
        wanted.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=".new-run-", dir=wanted.parent))
        try:
            draft.chmod(0o777 & ~_umask())
            write_bytes(draft / EXPERIMENT, experiment.to_toml().encode())
            (draft / CHAMPIONS).mkdir()
            (draft / EXPORTS).mkdir()
            return _name(draft, wanted)
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            raise


def _name(draft: Path, wanted: Path) -> Path:
    number = 1
    while True:
        path = wanted if number == 1 else wanted.with_name(f"{wanted.name}-{number}")
        number += 1
        if os.path.lexists(path):
            continue
        try:
            return draft.rename(path)
        except (FileExistsError, OSError) as error:
            if not os.path.lexists(path):  # else: another run took the name meanwhile
                raise error from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RunError(
            f"cannot write to {path}: {error.strerror}",
            remedy="free some space, or choose a folder that may be written with --out",
        ) from None


@dataclass(frozen=True)
class Run:
    """A run folder, opened for reading. What it says is as safe as a text file."""

    path: Path

    @cached_property
    def experiment_text(self) -> str:
        """The resolved experiment as TOML."""
        try:
            return (self.path / EXPERIMENT).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(f"cannot read {self.path / EXPERIMENT}: {error}") from None

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, its plugins loaded.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
        """
        return parse_experiment(self.experiment_text, str(self.path / EXPERIMENT))

    @cached_property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """The columns of the history by name."""
        return history.read_history(self.path / HISTORY)

    @cached_property
    def bests(self) -> NDArray[Any]:
        """Every generation's best, `score` and `genome`; generation g at index g − 1."""
        return history.read_bests(self.path / BESTS, self.experiment.space())

    def checkpoint(self) -> tuple[Checkpoint, str | None] | None:
        """The latest whole checkpoint and a warning if it is not the last; None before any.

        Raises:
            CheckpointError: no whole one is left.
        """
        current, previous = self.path / CHECKPOINT, self.path / PREVIOUS
        if not current.exists() and not previous.exists():
            return None
        return read_with_fallback(current, previous)

    def champion(self, generation: int | None = None) -> tuple[int, float, NDArray[Any]]:
        """The best individual of a generation, or of all: generation, score, genome (genes,).

        Raises:
            RunError: no generation is finished yet, there is no such one, or all failed.
        """
        bests = self.bests
        if generation is not None and not 1 <= generation <= len(bests):
            raise RunError(
                f"the run {self.path} has no generation {generation}",
                allowed=f"1 to {len(bests)}" if len(bests) else "none is finished yet",
            )
        chosen = bests if generation is None else bests[generation - 1 : generation]
        if not len(chosen) or not np.isfinite(chosen["score"].max()):
            raise RunError(
                f"the run {self.path} has no champion yet",
                remedy=f"go on with it: gaitsim resume {self.path}",
            )
        index = int(np.argmax(chosen["score"]))
        genome = chosen["genome"][index].astype(self.experiment.space().dtype)
        return generation or index + 1, float(chosen["score"][index]), genome

    def fingerprint(self) -> str:
        """SHA-256 of population, scores and history, times left out.

        Raises:
            RunError: no generation is finished yet.
        """
        found = self.checkpoint()
        if found is None:
            raise RunError(f"the run {self.path} has no finished generation yet")
        checkpoint, _ = found
        digest = hashlib.sha256()
        digest.update(checkpoint.genomes.tobytes())
        digest.update(checkpoint.scores.tobytes())
        for name, values in self.history.items():
            if name != "seconds":
                digest.update(name.encode())
                digest.update(values[: checkpoint.generation].tobytes())
        return digest.hexdigest()


class RunWriter:
    """A run folder, opened for writing by this process alone; a context manager.

    Attributes:
        warning: what a user should know about how it was found, or ''.
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
        self._lock = RunLock(path)
        try:
            remove_partials(path)
            self.run = Run(path)
            self.experiment = self.run.experiment
            self.warning = ""
            self.last = self._restore(any_version)
            if generations is not None:
                self._extend(generations)
            self._open_files()
        except BaseException:
            self._lock.release()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._history.close()
        self._bests.close()
        self._lock.release()

    def _restore(self, any_version: bool) -> Generation | None:
        found = self.run.checkpoint()
        if found is None:
            return None
        checkpoint, warning = found
        self.warning = warning or ""
        if not any_version:
            self._check_versions(checkpoint)
        space = self.experiment.space()
        if not space.contains(checkpoint.genomes):
            raise CheckpointError(
                f"the population in {self.path / CHECKPOINT} does not belong to the experiment "
                f"beside it",
                allowed=f"{space.genes} genes a genome, within the bounds of the organism",
                remedy="restore both files from one copy of the run",
            )
        return restored(checkpoint)

    def _extend(self, generations: int) -> None:
        done = self.last.number if self.last else 0
        if generations < done:
            raise RunError(
                f"the run {self.path} is at generation {done} already",
                allowed=f"--generations {done} or more",
                remedy=f"leave it, or begin a new one: gaitsim run {self.path / EXPERIMENT}",
            )
        self.experiment = with_overrides(self.experiment, [f"evolution.generations={generations}"])
        write_bytes(self.path / EXPERIMENT, self.experiment.to_toml().encode())

    def _check_versions(self, checkpoint: Checkpoint) -> None:
        now = versions(self.experiment)
        changed = [
            f"{name}: {then} then, {now[name]} now"
            for name, then in checkpoint.versions.items()
            if name in now and name not in ("numpy",) and now[name] != then
        ]
        if changed:
            raise RunError(
                f"the run {self.path} was made with other versions: " + "; ".join(changed),
                remedy="install those versions, or go on with these by --any-version: "
                "the rest may then not be what it would have been",
            )

    def _open_files(self) -> None:
        done = self.last.number if self.last else 0
        record = history.record_type(self.experiment.space()).itemsize
        rows = _offset_after_lines(self.path / HISTORY, done + 1 if done else 0)
        bests = self.path / BESTS
        stored = bests.stat().st_size if bests.exists() else 0
        if rows is None or stored < done * record:
            raise RunError(
                f"{HISTORY} or {BESTS} in {self.path} ends before generation {done}, which the "
                "checkpoint holds",
                remedy="restore the run's files from one copy",
            )
        with _writing(self.path):
            self._history = history.Growing(self.path / HISTORY, rows)
            self._bests = history.Growing(bests, done * record)

    def record(self, generation: Generation) -> None:
        """Write a finished generation: history and best first, the checkpoint last.

        A process killed in between leaves records past the checkpoint; they are cut off
        when the run is resumed.

        Raises:
            RunError: it cannot be written; the run stands as of the generation before.
        """
        best = generation.best
        values = history.row(generation)
        with _writing(self.path):
            if generation.number == 1:
                self._history.append(history.line(tuple(values)).encode())
            self._history.append(history.line(values).encode())
            layout = history.record_type(self.experiment.space())
            record = np.zeros((), layout)
            record["score"], record["genome"] = generation.scores[best], generation.genomes[best]
            self._bests.append(record.tobytes())
        if generation.is_champion:
            self._write_champion(generation)
        write_checkpoint(self.path / CHECKPOINT, self._checkpoint(generation), self.path / PREVIOUS)

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
        with _writing(folder):
            folder.mkdir(exist_ok=True)
        write_champion(folder / f"generation-{generation.number:06d}.pickle", champion)

    def _checkpoint(self, generation: Generation) -> Checkpoint:
        evaluation, progress = generation.evaluation, generation.progress
        return Checkpoint(
            experiment=self._toml,
            versions=self._versions,
            generation=generation.number,
            evaluations=progress.evaluations,
            genomes=generation.genomes,
            scores=evaluation.scores,
            terms=evaluation.terms,
            reasons={str(index): reason for index, reason in evaluation.reasons.items()},
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


def _offset_after_lines(path: Path, lines: int) -> int | None:
    """How many bytes the first `lines` lines of a file take; None if it has fewer."""
    if not lines:
        return 0
    try:
        data = path.read_bytes()
    except OSError:
        return None
    position = 0
    for _ in range(lines):
        position = data.find(b"\n", position) + 1
        if not position:
            return None
    return position
