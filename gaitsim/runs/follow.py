"""Follow a run while a process writes it: detect changes, and read new rows."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.folder import CHECKPOINT, EXPERIMENT, HISTORY, PREVIOUS, truncation_error
from gaitsim.runs.files.history import COLUMNS, MEAN, figures_of, parse_history
from gaitsim.runs.files.tables import Columns, open_records, read_head, read_rows
from gaitsim.runs.snapshot import RunSnapshot

Rows = Mapping[str, NDArray[np.float64]]
"""Rows of a history as columns by name, each (rows,)."""
Stamp = tuple[int, int, int]
"""Time of modification, size and inode of a file."""


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
        self.modified = _latest(stamp)
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


def last_modified(run: Path) -> float:
    """Return the time of the last change of a run's files, seconds since 1970; 0 without files."""
    return _latest(_stamps(run))


def _stamps(run: Path) -> tuple[Stamp | None, ...]:
    return tuple(_stamp(run / name) for name in (EXPERIMENT, CHECKPOINT, PREVIOUS, HISTORY))


def _latest(stamps: tuple[Stamp | None, ...]) -> float:
    return max((stamp[0] / 1e9 for stamp in stamps if stamp), default=0.0)


def _stamp(path: Path) -> Stamp | None:
    """Return the stamp of a file; None if it does not exist."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


class HistoryBuffer:
    """A run's history in memory, to which rows are added in constant amortised time.

    Args:
        rows: initial rows, from generation 1.
    """

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
