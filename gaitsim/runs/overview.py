"""Runs at a glance, cheap enough to read once a second while other processes write them."""

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
from gaitsim.runs.follow import Rows, RunFollower, modified
from gaitsim.runs.notes import read_note
from gaitsim.runs.resume import stop_reason_of
from gaitsim.runs.snapshot import RunSnapshot

POINTS = 256
"""Maximum number of points of a run's curve; a longer run has at least half as many."""
PATIENCE = 10
"""Time between two readings of a run, as a multiple of the time that reading takes."""

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
    """A run at a glance.

    Attributes:
        path: its folder.
        state: running (a process evolves it now), queued or paused (a process in the background
            waits), stopped (it can be resumed), failed (likewise, but its process in the
            background failed), finished (a stop condition holds), older or newer format (of
            another gaitsim), or damaged.
        plugins: the name of each plugin by kind.
        description: of its experiment.
        seed: of its experiment.
        generation: the last finished generation.
        generations: the number of planned generations.
        best: the best score comparable with the last generation; None before the first, and
            where all individuals failed.
        stage: the number of the current stage, from 1.
        seconds: the time that its evolution took.
        changed: the time of its last change, in seconds since 1970.
        curve: the best score over the generations, thinned; NaN where all failed.
        problem: why it cannot be read.
        failure: why its process in the background failed.
        note: its user's note, or why that cannot be read.
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
        """The name of its folder."""
        return self.path.name

    @property
    def evolves(self) -> bool:
        """Whether a process evolves it, or waits to."""
        return self.state in ("running", "paused", "queued")


class Curve:
    """The best score over the generations of a history that grows.

    Attributes:
        seconds: how long the generations took.
    """

    def __init__(self) -> None:
        self._best = np.empty(0)
        self.seconds = 0.0

    @property
    def points(self) -> tuple[float, ...]:
        """The best score of every `stride` generations; NaN where all failed."""
        stride = 1
        while len(self._best) >= POINTS * stride:
            stride *= 2
        return tuple(np.fmax.reduceat(self._best, np.arange(0, len(self._best), stride)).tolist())

    def extend(self, rows: Rows) -> None:
        """Add rows of the history; rows from generation 1 on replace all."""
        if not rows or not len(rows["generation"]):
            return
        if rows["generation"][0] == 1:
            self._best, self.seconds = np.empty(0), 0.0
        self.seconds += float(rows["seconds"].sum())
        best = np.where(np.isfinite(rows["best"]), rows["best"], np.nan)
        self._best = np.concatenate([self._best, best])


class RunsWatcher:
    """The runs in a folder, each read again only when it has changed.

    Args:
        root: the folder.
    """

    def __init__(self, root: Path) -> None:
        self._root = root
        self._watched: dict[Path, _Watched] = {}

    def look(
        self, progress: Callable[[Sequence[Overview], int], object] | None = None
    ) -> list[Overview]:
        """Return the runs there are now, oldest first.

        Args:
            progress: called after each run with those that were read, the latest change first,
                and the number of all.

        Raises:
            RunError: `root` is not a folder, or may not be read.
        """
        paths = list_runs(self._root)
        self._watched = {path: self._watched.get(path) or _Watched(path) for path in paths}
        names = runtime_names()
        found: dict[Path, Overview] = {}
        for path in paths if progress is None else sorted(paths, key=modified, reverse=True):
            run = self._watched[path].look(names)
            if run is not None:
                found[path] = run
            if progress is not None:
                progress([*found.values()], len(paths))
        return [found[path] for path in paths if path in found]


def overview(path: Path) -> Overview | None:
    """Return one run at a glance; None where it is gone."""
    return _Watched(path).look(runtime_names())


class _Watched:
    """One run with its latest overview."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._follower = RunFollower(path)
        self._curve = Curve()
        self._overview: Overview | None = None
        self._finished = False
        self._not_before = 0.0
        self._background = {runtime_file(path, kind).name for kind in (STATUS, FAILURE)}

    def look(self, names: Collection[str]) -> Overview | None:
        """Return the run as it is now, given the names of the files of background processes."""
        if not os.path.lexists(self._path / EXPERIMENT):
            return None
        now = time.monotonic()
        run = self._follower.poll() if now >= self._not_before else None
        if run is not None:
            self._overview = self._read(run)
            self._not_before = now + PATIENCE * (time.monotonic() - now)
        found = self._overview
        if found is None:
            return None
        note = self._note()
        if found.note != note:
            found = self._overview = replace(found, note=note)
        if found.problem is not None:
            return found
        state, failure = self._state(self._background.isdisjoint(names))
        if found.state != state or str(found.failure) != str(failure):
            found = self._overview = replace(found, state=state, failure=failure)
        return found

    def _note(self) -> str:
        try:
            return read_note(self._path)
        except RunError as error:
            return f"({error.what})"

    def _state(self, alone: bool) -> tuple[State, GaitsimError | None]:
        process = None if alone else background_process(self._path)
        if process is not None and process.state in ("queued", "paused"):
            return process.state, None
        if process is not None or is_locked(self._path):
            return "running", None
        failure = None if alone else last_failure(self._path)
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
    """Return the error of a checkpoint of another format, whose experiment may be unknown, too."""
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
