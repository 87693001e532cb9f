"""A run on disk, opened for reading."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import CheckpointError, ExperimentError, GaitsimError, RunError
from gaitsim.experiment import Experiment, Overrides, parse_experiment
from gaitsim.experiment.problems import COMMAND_LINE
from gaitsim.individual import Individual
from gaitsim.registry import KINDS, entries
from gaitsim.runs.compatibility import fitting, misfit
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.checkpoint import Checkpoint, read_with_fallback
from gaitsim.runs.files.folder import (
    BESTS,
    CHECKPOINT,
    EXPERIMENT,
    EXPORTS,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    command,
)
from gaitsim.runs.files.history import (
    best_terms,
    header,
    read_bests,
    read_history,
    read_islands,
    record_type,
    used_terms,
)
from gaitsim.runs.stages import (
    Change,
    RunStage,
    changes,
    comparable,
    islands_in,
    options,
    pending,
    stages_of,
)


def versions(experiment: Experiment) -> dict[str, str]:
    """What a run depends on: gaitsim, NumPy, and the package of each plugin."""
    found = {"gaitsim": version("gaitsim"), "numpy": np.__version__}
    for kind, entry in experiment.entries.items():
        found[f"{kind} {entry.name}"] = f"{entry.package} {entry.version}"
    return found


def _missing(found: Mapping[str, str]) -> list[GaitsimError]:
    """What a run's plugins that are not installed came with, by the versions of a checkpoint."""
    known = {f"{kind} {name}" for kind in KINDS for name in entries(kind)}
    return [
        GaitsimError(
            f"the {key} of this run came with the package {package}",
            remedy=f"install it: pip install {'=='.join(package.split())}",
        )
        for key, package in found.items()
        if key.split()[0] in KINDS and key not in known
    ]


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
        return self.experiment_with()

    def experiment_with(
        self, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> Experiment:
        """Return the experiment with options changed by key, its plugins loaded.

        Raises:
            ExperimentError: with all the problems of both.
        """
        try:
            source = str(self.path / EXPERIMENT)
            return parse_experiment(self.experiment_text, source, overrides, place)
        except ExperimentError as error:
            try:
                found = self.checkpoint()
            except RunError:
                found = None
            missing = _missing(found[0].versions if found else {})
            raise ExperimentError([*error.problems, *missing]) from None

    @property
    def stages(self) -> tuple[RunStage, ...]:
        """The stages of the run, the present one last; () before the first generation."""
        found = self.checkpoint()
        return stages_of(found[0]) if found else ()

    def stage_at(self, generation: int) -> RunStage:
        """The stage that a generation belongs to.

        Raises:
            RunError: there is no such generation.
        """
        stages = self.stages
        if not stages:
            raise self.unfinished()
        for stage in stages:
            if stage.first <= generation <= stage.last:
                return stage
        raise self._no_generation(generation, stages[-1].last)

    def experiment_at(self, generation: int) -> Experiment:
        """The experiment as it was when `generation` was evolved, its plugins loaded.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
            RunError: there is no such generation.
        """
        stage = self.stage_at(generation)
        text = stage.experiment
        if text not in self._parsed:
            if not changes(text, self.experiment_text):
                return self.experiment
            source = f"{self.path}, the experiment of stage {stage.number}"
            try:
                self._parsed[text] = parse_experiment(text, source)
            except ExperimentError as error:
                raise ExperimentError([*error.problems, *_missing(stage.versions)]) from None
        return self._parsed[text]

    @cached_property
    def _parsed(self) -> dict[str, Experiment]:
        return {}

    @property
    def pending(self) -> tuple[Change, ...]:
        """What was changed since the last generation, and begins a stage with the next one.

        Raises:
            ExperimentError: the experiment has problems.
        """
        found = self.checkpoint()
        if found is None or found[0].experiment == self.experiment_text:
            return ()
        return pending(found[0], self.experiment)

    @property
    def comparable(self) -> int:
        """The first generation whose scores can be compared with those of the last one.

        Those before it were judged by another fitness, or of another body.

        Raises:
            RunError: no generation is finished yet.
        """
        stages = self.stages
        if not stages:
            raise self.unfinished()
        return comparable(stages)

    @property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """The columns of the history by name, each (generations,); {} before the first one.

        Raises:
            RunError: it is damaged, or ends before the checkpoint.
        """
        found = self.checkpoint()
        return self._history(found[0]) if found else {}

    def _history(self, checkpoint: Checkpoint) -> dict[str, NDArray[np.float64]]:
        generation = checkpoint.generation
        columns = read_history(self.path / HISTORY)
        rows = len(columns["generation"]) if columns else 0
        if rows < generation:
            raise self.ends_early(HISTORY, rows, generation)
        columns = {name: values[:generation] for name, values in columns.items()}
        terms = [name for name in checkpoint.terms if name in columns]
        # Without those of a stage whose first generation was not finished.
        return {name: columns[name] for name in header(used_terms(columns, terms))}

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
    def islands(self) -> NDArray[np.float64]:
        """The best score of each island by generation, (generations, islands).

        Of a run of one population, (generations, 1): the best scores of the history.

        Raises:
            RunError: it is damaged, or ends before the checkpoint.
        """
        found = self.checkpoint()
        if found is None:
            return np.empty((0, 1))
        last, number = found[0].generation, islands_in(found[0].experiment)
        if number == 1:
            return self._history(found[0])["best"][:, None]
        bests = read_islands(self.path / ISLANDS, number)
        if len(bests) < last:
            raise self.ends_early(ISLANDS, len(bests), last)
        return bests[:last]

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
            self._check_beginning()
            return None
        return read_with_fallback(current, previous, rename=keep_damaged)

    def _check_beginning(self) -> None:
        """Check that a run without a checkpoint never had one.

        A row of the history is written before its checkpoint, so there may be one.

        Raises:
            CheckpointError: there was one.
        """
        try:
            with (self.path / HISTORY).open("rb") as file:
                rows = [*islice(file, 3)][1:]
        except OSError:
            return
        if len(rows) > 1:
            raise CheckpointError(
                f"{CHECKPOINT} and {PREVIOUS} are gone, but {HISTORY} holds generations",
                where=str(self.path),
                remedy="restore them from a copy; to begin anew: "
                + command("run", self.path / EXPERIMENT),
            )

    def check_fit(self, checkpoint: Checkpoint) -> None:
        """Check that the population of a checkpoint is one of the experiment beside it.

        Raises:
            CheckpointError: it is not.
        """
        population, genomes = self.experiment.individuals, checkpoint.genomes
        number, before = self.experiment.islands.number, islands_in(checkpoint.experiment)
        wrong = misfit(self.experiment, genomes, checkpoint.experiment, "the population")
        if wrong or len(genomes) != population or number != before:
            asked = f"{population} individuals"
            reason = wrong or f"it asks for {asked if number == before else f'{number} islands'}"
            raise CheckpointError(
                f"the population of {len(genomes)} with {genomes.shape[1]} genes in "
                f"{self.path / CHECKPOINT} does not belong to the experiment beside it: {reason}",
                where=str(self.path / EXPERIMENT),
                allowed=f"a population of {population} with {fitting(self.experiment)}",
                remedy="take back what was changed in the experiment, or begin a new run with it",
            )

    def ends_early(self, name: str, found: int, generation: int) -> RunError:
        """The error of a file that lacks records which the checkpoint counts."""
        there = (self.path / name).exists()
        what = f"{name} ends at generation {found}" if there else f"there is no {name}"
        return RunError(
            f"{what}, but the checkpoint is of generation {generation}",
            where=str(self.path / name),
            remedy="restore all files of the run from one copy",
        )

    def individual(self, generation: int | None = None) -> Individual:
        """Return the best individual of a generation, or of all.

        Of all, only those count whose scores can be compared with the last generation's.

        Raises:
            ExperimentError: its experiment has problems, such as a plugin that is not installed.
            RunError: no generation is finished yet, there is no such one, or all failed; or the
                files of the run contradict each other.
        """
        bests = self.bests
        if not len(bests):
            raise self.unfinished()
        if generation is not None and not 1 <= generation <= len(bests):
            raise self._no_generation(generation, len(bests))
        first, history = self.comparable, self.history
        number = generation or first + int(np.argmax(bests["score"][first - 1 :]))
        best, recorded = bests[number - 1], history["best"][number - 1]
        if best["score"] != recorded:
            raise RunError(
                f"the best score of generation {number} is {best['score']:g} in {BESTS}, but "
                f"{recorded:g} in {HISTORY}",
                where=str(self.path),
                remedy="restore all files of the run from one copy",
            )
        if not np.isfinite(best["score"]):
            which = f"generation {generation}"
            if generation is None:
                which = "any generation" if first == 1 else f"all generations from {first} on"
            raise RunError(
                f"the run {self.path} has no champion: every individual of {which} failed",
                remedy=f"see why: {command('show', self.path)}",
            )
        experiment = self.experiment_at(number)
        return Individual(
            experiment,
            float(best["score"]),
            best_terms(history, number),
            number,
            best["genome"].astype(experiment.space().dtype),
            self.path,
        )

    def exports(self) -> Path:
        """The folder for what leaves the run, made if it is not there.

        Raises:
            RunError: it cannot be made.
        """
        folder = self.path / EXPORTS
        with writing(folder):
            folder.mkdir(exist_ok=True)
        return folder

    def _no_generation(self, generation: int, last: int) -> RunError:
        return RunError(
            f"the run {self.path} has no generation {generation}", allowed=f"1 to {last}"
        )

    def unfinished(self) -> RunError:
        """The error of a run that has not come to the end of its first generation."""
        return RunError(
            f"the run {self.path} has no finished generation yet",
            remedy=f"go on with it: {command('resume', self.path)}",
        )

    def fingerprint(self) -> str:
        """SHA-256 of population, scores, history and stages; times and column names left out.

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
        for name, values in self._history(checkpoint).items():
            if name != "seconds":
                digest.update(values.tobytes())
        stages = stages_of(checkpoint)
        for stage in stages if len(stages) > 1 else ():
            digest.update(f"{stage.first} {options(stage.experiment)}".encode())
        return digest.hexdigest()
