"""Watch the runs in a folder: cheap enough for once a second while other processes write them."""

import math
import os
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.background import runtime_names, status_names
from gaitsim.runs.files.folder import EXPERIMENT, list_runs
from gaitsim.runs.files.safe_pickle import NewerVersionError, SchemaVersionError
from gaitsim.runs.follow import Rows, RunFollower, last_modified
from gaitsim.runs.notes import read_note
from gaitsim.runs.overview import Overview, State, run_state
from gaitsim.runs.resume import stop_reason_of
from gaitsim.runs.snapshot import RunSnapshot

POINTS = 256
"""Maximum number of points of a run's curve; a longer run has at least half as many."""
READ_INTERVAL = 10
"""Minimum time between two reads of a run, as a multiple of the duration of a read."""


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
        self._background = status_names(path)

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
        state, failure = run_state(
            self._path,
            finished=self._finished,
            background=not self._background.isdisjoint(names),
        )
        if found.state != state or str(found.failure) != str(failure):
            found = self._overview = replace(found, state=state, failure=failure)
        return found

    def _note(self) -> str:
        try:
            return read_note(self._path)
        except RunError as error:
            return f"({error.what})"

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
