"""A run on disk, opened for reading."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import CheckpointError, ExperimentError, GaitsimError, RunError
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import KINDS, containing, entries
from gaitsim.runs.atomic import writing
from gaitsim.runs.checkpoint import Checkpoint, read_with_fallback
from gaitsim.runs.folder import (
    BESTS,
    CHECKPOINT,
    EXPERIMENT,
    EXPORTS,
    HISTORY,
    PREVIOUS,
    command,
)
from gaitsim.runs.history import read_bests, read_history, record_type


def versions(experiment: Experiment) -> dict[str, str]:
    """What a run depends on: gaitsim, NumPy, and the package of each plugin."""
    found = {"gaitsim": version("gaitsim"), "numpy": np.__version__}
    for kind, entry in experiment.entries.items():
        found[f"{kind} {entry.name}"] = f"{entry.package} {entry.version}"
    return found


@dataclass(frozen=True)
class Run:
    """A run folder, opened for reading. What it says is as safe as a text file.

    A run may grow while it is read: everything but the experiment is read anew each
    time, up to the generation of the checkpoint. Records past it are those of a
    generation that is being written, or that a killed process left half written.
    """

    path: Path

    @cached_property
    def experiment_text(self) -> str:
        """The resolved experiment as TOML."""
        path = self.path / EXPERIMENT
        try:
            return path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not a text in UTF-8"
            raise RunError(
                f"cannot read {path}: {reason}",
                remedy="restore it from a copy of the run; the checkpoint holds its text, too",
            ) from None

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, its plugins loaded.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
        """
        try:
            return parse_experiment(self.experiment_text, str(self.path / EXPERIMENT))
        except ExperimentError as error:
            raise ExperimentError([*error.problems, *self._missing()]) from None

    def experiment_at(self, generation: int) -> Experiment:
        """The experiment as it was when `generation` was evolved."""
        return self.experiment

    def _missing(self) -> list[GaitsimError]:
        """What the run's plugins that are not installed came with."""
        try:
            found = self.checkpoint()
        except RunError:
            found = None
        known = {f"{kind} {name}" for kind in KINDS for name in entries(kind)}
        return [
            GaitsimError(
                f"the {key} of this run came with the package {package}",
                remedy=f"install it: pip install {'=='.join(package.split())}",
            )
            for key, package in (found[0].versions if found else {}).items()
            if key.split()[0] in KINDS and key not in known
        ]

    @property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """The columns of the history by name, each (generations,); {} before the first one.

        Raises:
            RunError: it is damaged, or ends before the checkpoint.
        """
        return self._history(self.generation)

    def _history(self, generation: int) -> dict[str, NDArray[np.float64]]:
        if generation == 0:
            return {}
        columns = read_history(self.path / HISTORY)
        rows = len(columns["generation"]) if columns else 0
        if rows < generation:
            raise self.ends_early(HISTORY, rows, generation)
        return {name: values[:generation] for name, values in columns.items()}

    @property
    def bests(self) -> NDArray[Any]:
        """Every generation's best, `score` and `genome`; generation g at index g − 1.

        Raises:
            RunError: they are damaged, end before the checkpoint, or are of another body.
        """
        space = self.experiment.space()
        found = self.checkpoint()
        if found is None:
            return np.empty(0, record_type(space))
        self.check_fit(found[0])
        bests = read_bests(self.path / BESTS, space)
        if len(bests) < found[0].generation:
            raise self.ends_early(BESTS, len(bests), found[0].generation)
        return bests[: found[0].generation]

    @property
    def generation(self) -> int:
        """Of the checkpoint; 0 before the first one."""
        found = self.checkpoint()
        return found[0].generation if found else 0

    def checkpoint(self, *, keep_damaged: bool = False) -> tuple[Checkpoint, str | None] | None:
        """The latest whole checkpoint and a warning if it is not the last; None before any.

        Args:
            keep_damaged: rename a damaged one, so that the next one does not replace it;
                for the writer of the run.

        Raises:
            CheckpointError: no whole one is left.
        """
        current, previous = self.path / CHECKPOINT, self.path / PREVIOUS
        if not current.exists() and not previous.exists():
            return None
        return read_with_fallback(current, previous, rename=keep_damaged)

    def check_fit(self, checkpoint: Checkpoint) -> None:
        """Check that the population of a checkpoint is one of the experiment beside it.

        Raises:
            CheckpointError: it is not.
        """
        space, population = self.experiment.space(), self.experiment.evolution.population
        genomes = checkpoint.genomes
        with containing(self.experiment.entries["organism"], "looking at genomes"):
            fits = space.contains(genomes)
        if not fits or len(genomes) != population:
            raise CheckpointError(
                f"the population of {len(genomes)} with {genomes.shape[1]} genes in "
                f"{self.path / CHECKPOINT} does not belong to the experiment beside it",
                where=str(self.path / EXPERIMENT),
                allowed=f"a population of {population} with {space.genes} {space.name} genes, "
                "within the bounds of the organism",
                remedy="take back what was changed in the experiment, or begin a new run with it",
            )

    def ends_early(self, name: str, found: int, generation: int) -> RunError:
        """The error of a file that lacks records which the checkpoint counts."""
        return RunError(
            f"{name} ends at generation {found}, but the checkpoint is of generation {generation}",
            where=str(self.path / name),
            remedy="restore all files of the run from one copy",
        )

    def champion(self, generation: int | None = None) -> tuple[int, float, NDArray[Any]]:
        """The best individual of a generation, or of all: generation, score, genome (genes,).

        Raises:
            RunError: no generation is finished yet, there is no such one, or all failed.
        """
        bests = self.bests
        if not len(bests):
            raise self.unfinished()
        if generation is not None and not 1 <= generation <= len(bests):
            raise RunError(
                f"the run {self.path} has no generation {generation}",
                allowed=f"1 to {len(bests)}",
            )
        number = generation or int(np.argmax(bests["score"])) + 1
        best = bests[number - 1]
        if not np.isfinite(best["score"]):
            which = "any generation" if generation is None else f"generation {generation}"
            raise RunError(
                f"the run {self.path} has no champion: every individual of {which} failed",
                remedy=f"see why: {command('show', self.path)}",
            )
        return number, float(best["score"]), best["genome"].astype(self.experiment.space().dtype)

    def exports(self) -> Path:
        """The folder for what leaves the run, made if it is not there.

        Raises:
            RunError: it cannot be made.
        """
        folder = self.path / EXPORTS
        with writing(folder):
            folder.mkdir(exist_ok=True)
        return folder

    def unfinished(self) -> RunError:
        """The error of a run that has not come to the end of its first generation."""
        return RunError(
            f"the run {self.path} has no finished generation yet",
            remedy=f"go on with it: {command('resume', self.path)}",
        )

    def fingerprint(self) -> str:
        """SHA-256 of population, scores and history, times left out.

        Raises:
            RunError: no generation is finished yet.
        """
        found = self.checkpoint()
        if found is None:
            raise self.unfinished()
        checkpoint, _ = found
        digest = hashlib.sha256()
        digest.update(checkpoint.genomes.tobytes())
        digest.update(checkpoint.scores.tobytes())
        for name, values in self._history(checkpoint.generation).items():
            if name != "seconds":
                digest.update(name.encode())
                digest.update(values.tobytes())
        return digest.hexdigest()
