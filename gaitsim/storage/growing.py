"""Read runs while other processes write them: only what has changed."""

import math
import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim import toml
from gaitsim.errors import GaitsimError
from gaitsim.storage.background import RunState, runtime_names, status_names
from gaitsim.storage.files.folder import (
    CHANGING,
    EXPERIMENT,
    HISTORY,
    last_modified,
    list_runs,
    truncation_error,
)
from gaitsim.storage.files.history import COLUMNS, MEAN, figures_of, parse_history
from gaitsim.storage.files.safe_pickle import NewerVersionError, SchemaVersionError
from gaitsim.storage.files.tables import Columns, open_records, read_head, read_rows
from gaitsim.storage.overview import Overview, annotations, run_state, terms_of
from gaitsim.storage.snapshot import RunSnapshot

Rows = Mapping[str, NDArray[np.float64]]
"""Rows of a history as columns by name, each (rows,)."""
Stamp = tuple[int, int, int]
"""Time of modification, size and inode of a file."""

POINTS = 256
"""Maximum number of points of a run's curve; a longer run has at least half as many."""
READ_INTERVAL = 10
"""Minimum time between two reads of a run, as a multiple of the duration of a read."""


class RunFollower:
    """A run folder that is re-read only when its files have changed.

    Attributes:
        path: path of the folder.
        modified: time of the last change of a file, seconds since 1970; 0 without files.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.modified = 0.0
        self._stamp: tuple[Stamp | None, ...] = ()
        self._head, self._row, self._offset, self._next = b"", b"", 0, 1

    def poll(self) -> RunSnapshot | None:
        """Return the current run; None if no file has changed since the last call."""
        stamp = _stamps(self.path)
        if stamp == self._stamp:
            return None
        self._stamp = stamp
        self.modified = max((one[0] / 1e9 for one in stamp if one), default=0.0)
        return RunSnapshot(self.path)

    def read_rows(self, run: RunSnapshot) -> Rows:
        """Return the new rows of the history, up to the generation of a run.

        If the file was rewritten, all rows are returned, from generation 1.
        """
        last, path = run.generation, self.path / HISTORY
        columns: Rows = {}
        with open_records(path) as file:
            head = read_head(path, file)
            file.seek(max(self._offset - len(self._row), 0))
            if head != self._head or file.read(len(self._row)) != self._row:
                # The file was rewritten, with new columns or from an older checkpoint.
                self._head, self._row, self._offset, self._next = head, b"", len(head), 1
                file.seek(len(head))
            left = max(last + 1 - self._next, 0)
            rows = read_rows(path, file, head, left) if head else b""
        if head:
            columns = parse_history(path, head, rows, self._next)
            self._offset += len(rows)
            self._next += rows.count(b"\n")
            self._row = rows[rows.rfind(b"\n", 0, -1) + 1 :] or self._row
        if self._next <= last:
            self._head = b""  # the next call re-reads the rows, which are not returned now
            raise truncation_error(run.path, HISTORY, self._next - 1, last)
        return columns


def _stamps(run: Path) -> tuple[Stamp | None, ...]:
    return tuple(_stamp(run / name) for name in CHANGING)


def _stamp(path: Path) -> Stamp | None:
    """Return the stamp of a file; None if it does not exist."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


class HistoryBuffer:
    """A run's history in memory, to which rows are added in constant amortised time."""

    def __init__(self, rows: Rows | None = None) -> None:
        self._columns: Columns = {}
        self._length = 0
        if rows:
            self.extend(rows)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a column, (generations,), which must not be modified."""
        return self._columns[name][: self._length]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    @property
    def terms(self) -> list[str]:
        """The names of the terms, in order of appearance."""
        return [name for name in self._columns if MEAN + name in self._columns]

    @property
    def figures(self) -> list[str]:
        """The names of the figures of the search."""
        return figures_of(self._columns)

    def extend(self, rows: Rows) -> bool:
        """Add new rows, skipping known ones. Rows that start at generation 1 replace all.

        Returns:
            Whether the rows are contiguous with the known ones. If not, nothing is added.
        """
        numbers = rows.get(COLUMNS[0])
        if numbers is None or not len(numbers):
            return True
        if numbers[0] == 1:
            self._columns, self._length = {}, 0
        if numbers[0] > self._length + 1:
            return False
        skipped = self._length + 1 - int(numbers[0])
        added = len(numbers) - skipped
        if added <= 0:
            return True
        end = self._length + added
        for name in rows:
            if name not in self._columns:
                self._columns[name] = np.full(end, np.nan)
        for name, column in self._columns.items():
            grown = column
            if len(column) < end:
                grown = np.full(max(end, 2 * len(column)), np.nan)
                grown[: self._length] = column[: self._length]
                self._columns[name] = grown
            grown[self._length : end] = rows[name][skipped:] if name in rows else np.nan
        self._length = end
        return True


def curve(best: NDArray[np.float64]) -> tuple[float, ...]:
    """Return the best score of each group of consecutive generations; NaN where all failed.

    Args:
        best: best score of each generation, (generations,).
    """
    stride = 1
    while len(best) >= POINTS * stride:
        stride *= 2
    finite = np.where(np.isfinite(best), best, np.nan)
    return tuple(np.fmax.reduceat(finite, np.arange(0, len(best), stride)).tolist())


class RunsWatcher:
    """The runs in a folder, each re-read only when it has changed."""

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
        self._history = HistoryBuffer()  # with the columns of the overview alone
        self._terms: Mapping[str, float] = {}
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
        note, tags = annotations(self._path)
        if (found.note, found.tags) != (note, tags):
            found = self._overview = replace(found, note=note, tags=tags)
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

    def _read(self, run: RunSnapshot) -> Overview:
        modified = self._follower.modified
        known: dict[str, Any] = {"path": self._path, "changed": modified, "plugins": {}}
        try:
            outline = run.outline
            known["plugins"], known["seed"] = outline.plugins, outline.seed
            known["description"] = outline.description
            known["options"] = toml.flatten({"seed": outline.seed, **outline.sections})
            known["generations"] = outline.evolution.generations
            checkpoint = run.checkpoint
            if checkpoint is not None:
                known["generation"] = checkpoint.generation
                known["evaluations"] = checkpoint.evaluations
                known["stage"] = len(checkpoint.stages) + 1
                best = checkpoint.best_score
                known["best"] = best if math.isfinite(best) else None
                self._finished = bool(run.stop_reason)
            rows = self._follower.read_rows(run)
            if rows and len(rows["generation"]):
                columns = ("generation", "best", "seconds")
                self._history.extend({name: rows[name] for name in columns})
                self._terms = terms_of({name: float(rows[name][-1]) for name in rows})
        except GaitsimError as error:
            problem = _foreign_format(run) or error
            return Overview(state=_state_of(problem), problem=problem, **known)
        if self._history:
            known["curve"] = curve(self._history["best"])
            known["seconds"] = float(self._history["seconds"].sum())
        known["terms"] = self._terms
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


def _state_of(problem: GaitsimError) -> RunState:
    if isinstance(problem, NewerVersionError):
        return "newer format"
    return "older format" if isinstance(problem, SchemaVersionError) else "damaged"
