"""Overviews of runs, cheap enough to read once a second while other processes write the runs."""

import math
import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.background import (
    FAILURE,
    STATUS,
    background_process,
    last_failure,
    runtime_file,
    runtime_names,
)
from gaitsim.runs.files.folder import EXPERIMENT, list_runs
from gaitsim.runs.files.lock import is_locked
from gaitsim.runs.files.safe_pickle import NewerVersionError, SchemaVersionError
from gaitsim.runs.follow import Rows, RunFollower, last_modified
from gaitsim.runs.notes import read_note
from gaitsim.runs.resume import stop_reason_of
from gaitsim.runs.snapshot import RunSnapshot

POINTS = 256
"""Maximum number of points of a run's curve; a longer run has at least half as many."""
READ_INTERVAL = 10
"""Minimum time between two reads of a run, as a multiple of the duration of a read."""

State = Literal[
    "running",
    "queued",
    "paused",
    "stopped",
    "failed",
    "finished",
    "older format",
    "newer format",
    "damaged",
]


@dataclass(frozen=True)
class Overview:
    """An overview of a run.

    Attributes:
        path: folder of the run.
        state: running (a process is evolving it), queued or paused (a background process is
            waiting), stopped (it can be resumed), failed (it can be resumed, but its background
            process failed), finished (a stop condition holds), older or newer format (written by
            another version of gaitsim), or damaged.
        plugins: name of each plugin by kind.
        description: description of the experiment.
        seed: seed of the experiment.
        generation: last finished generation.
        generations: number of planned generations.
        best: best score among those comparable with the last generation; None before the first
            generation, or if all individuals failed.
        stage: number of the current stage, counted from 1.
        seconds: duration of the evolution.
        changed: time of the last change, in seconds since 1970.
        curve: best score over the generations, thinned; NaN where all failed.
        problem: error that prevents reading the run; None if it can be read.
        failure: error of its background process; None if that did not fail.
        note: note of the user, or the reason why it cannot be read, in parentheses.
    """

    path: Path
    state: State
    plugins: Mapping[str, str]
    description: str = ""
    seed: int = 0
    generation: int = 0
    generations: int = 0
    best: float | None = None
    stage: int = 1
    seconds: float = 0.0
    changed: float = 0.0
    curve: tuple[float, ...] = ()
    problem: GaitsimError | None = None
    failure: GaitsimError | None = None
    note: str = ""

    @property
    def name(self) -> str:
        """The name of the run's folder."""
        return self.path.name

    @property
    def evolves(self) -> bool:
        """Whether a process is evolving the run, or waiting to."""
        return self.state in ("running", "paused", "queued")


class Curve:
    """The best score over the generations of a growing history.

    Attributes:
        seconds: duration of the generations.
    """

    def __init__(self) -> None:
        self._best = np.empty(0)
        self.seconds = 0.0

    @property
    def points(self) -> tuple[float, ...]:
        """The best score of each group of consecutive generations; NaN where all failed."""
        stride = 1
        while len(self._best) >= POINTS * stride:
            stride *= 2
        return tuple(np.fmax.reduceat(self._best, np.arange(0, len(self._best), stride)).tolist())

    def extend(self, rows: Rows) -> None:
        """Add rows of the history; rows that start at generation 1 replace all."""
        if not rows or not len(rows["generation"]):
            return
        if rows["generation"][0] == 1:
            self._best, self.seconds = np.empty(0), 0.0
        self.seconds += float(rows["seconds"].sum())
        best = np.where(np.isfinite(rows["best"]), rows["best"], np.nan)
        self._best = np.concatenate([self._best, best])


class RunsWatcher:
    """The runs in a folder, each re-read only when it has changed.

    Args:
        root: path of the folder.
    """

    def __init__(self, root: Path) -> None:
        self._root = root
        self._watched: dict[Path, _WatchedRun] = {}

    def poll(
        self, progress: Callable[[Sequence[Overview], int], object] | None = None
    ) -> list[Overview]:
        """Return the current runs, oldest first.

        Args:
            progress: callback after each run, which receives the runs read so far, most recently
                changed first, and the number of all runs.

        Raises:
            RunError: `root` is not a folder, or cannot be read.
        """
        paths = list_runs(self._root)
        self._watched = {path: self._watched.get(path) or _WatchedRun(path) for path in paths}
        names = runtime_names()
        found: dict[Path, Overview] = {}
        for path in paths if progress is None else sorted(paths, key=last_modified, reverse=True):
            run = self._watched[path].poll(names)
            if run is not None:
                found[path] = run
            if progress is not None:
                progress([*found.values()], len(paths))
        return [found[path] for path in paths if path in found]


def overview(path: Path) -> Overview | None:
    """Return the overview of a run; None if it no longer exists."""
    return _WatchedRun(path).poll(runtime_names())


class _WatchedRun:
    """One run with its latest overview."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._follower = RunFollower(path)
        self._curve = Curve()
        self._overview: Overview | None = None
        self._finished = False
        self._not_before = 0.0
        self._background = {runtime_file(path, kind).name for kind in (STATUS, FAILURE)}

    def poll(self, names: Collection[str]) -> Overview | None:
        """Return the current overview, given the names of all files of background processes."""
        if not os.path.lexists(self._path / EXPERIMENT):
            return None
        now = time.monotonic()
        run = self._follower.poll() if now >= self._not_before else None
        if run is not None:
            self._overview = self._read(run)
            self._not_before = now + READ_INTERVAL * (time.monotonic() - now)
        found = self._overview
        if found is None:
            return None
        note = self._note()
        if found.note != note:
            found = self._overview = replace(found, note=note)
        if found.problem is not None:
            return found
        state, failure = self._state(background=not self._background.isdisjoint(names))
        if found.state != state or str(found.failure) != str(failure):
            found = self._overview = replace(found, state=state, failure=failure)
        return found

    def _note(self) -> str:
        try:
            return read_note(self._path)
        except RunError as error:
            return f"({error.what})"

    def _state(self, background: bool) -> tuple[State, GaitsimError | None]:
        """Return the state and failure of a run; `background`: whether it has runtime files."""
        process = background_process(self._path) if background else None
        if process is not None and process.state in ("queued", "paused"):
            return process.state, None
        if process is not None or is_locked(self._path):
            return "running", None
        failure = last_failure(self._path) if background else None
        state: State = "failed" if failure else "finished" if self._finished else "stopped"
        return state, failure

    def _read(self, run: RunSnapshot) -> Overview:
        modified = self._follower.modified
        known: dict[str, Any] = {"path": self._path, "changed": modified, "plugins": {}}
        try:
            outline = run.outline
            known["plugins"], known["seed"] = outline.plugins, outline.seed
            known["description"] = outline.description
            known["generations"] = outline.evolution.generations
            checkpoint = run.checkpoint
            if checkpoint is not None:
                known["generation"] = checkpoint.generation
                known["stage"] = len(checkpoint.stages) + 1
                best = checkpoint.best_score
                known["best"] = best if math.isfinite(best) else None
                self._finished = bool(stop_reason_of(run))
            self._curve.extend(self._follower.read_rows(run))
        except GaitsimError as error:
            problem = _foreign_format(run) or error
            return Overview(state=_state_of(problem), problem=problem, **known)
        known |= {"curve": self._curve.points, "seconds": self._curve.seconds}
        return Overview(state="stopped", **known)


def _foreign_format(run: RunSnapshot) -> GaitsimError | None:
    """Return the error of a checkpoint in another format; None for other checkpoints.

    It takes precedence over errors of the experiment, which may be in another format, too.
    """
    try:
        _ = run.checkpoint
    except SchemaVersionError as error:
        return error
    except GaitsimError:
        pass
    return None


def _state_of(problem: GaitsimError) -> State:
    if isinstance(problem, NewerVersionError):
        return "newer format"
    return "older format" if isinstance(problem, SchemaVersionError) else "damaged"
