"""Follow a run while a process writes it: what has changed, and what was added."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.folder import CHECKPOINT, EXPERIMENT, HISTORY, PREVIOUS, ends_early
from gaitsim.runs.files.history import COLUMNS, MEAN, figures_of, parse_history
from gaitsim.runs.files.tables import Columns, opened, read_head, read_rows
from gaitsim.runs.snapshot import RunSnapshot

Rows = Mapping[str, NDArray[np.float64]]
"""Rows of a history as columns by name, (rows,) each."""
Stamp = tuple[int, int, int]
"""When a file changed, its size, and its number."""


class RunFollower:
    """A run folder, read again only when its files have changed.

    Attributes:
        path: the folder.
        modified: when a file last changed, seconds since 1970; 0 where there is none.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.modified = 0.0
        self._stamp: tuple[Stamp | None, ...] = ()
        self._head, self._row, self._offset, self._next = b"", b"", 0, 1

    def poll(self) -> RunSnapshot | None:
        """Return the run as it is now; None where no file has changed since the last call."""
        stamp = _stamps(self.path)
        if stamp == self._stamp:
            return None
        self._stamp = stamp
        self.modified = _latest(stamp)
        return RunSnapshot(self.path)

    def read_rows(self, run: RunSnapshot) -> Rows:
        """Return the rows of the history that were added, up to the generation of a run.

        Where the file was rewritten, all rows come again, from generation 1 on.

        Raises:
            RunError: the history cannot be read, is damaged, or ends before the checkpoint.
        """
        last, path = run.generation, self.path / HISTORY
        columns: Rows = {}
        with opened(path) as file:
            head = read_head(path, file)
            file.seek(max(self._offset - len(self._row), 0))
            if head != self._head or file.read(len(self._row)) != self._row:
                # Rewritten, with columns for other terms or from an older checkpoint.
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
            self._head = b""  # what was read is not returned: read it again
            raise ends_early(run.path, HISTORY, self._next - 1, last)
        return columns


def modified(run: Path) -> float:
    """Return when a file of a run last changed, in seconds since 1970; 0 where there is none."""
    return _latest(_stamps(run))


def _stamps(run: Path) -> tuple[Stamp | None, ...]:
    return tuple(_stamp(run / name) for name in (EXPERIMENT, CHECKPOINT, PREVIOUS, HISTORY))


def _latest(stamps: tuple[Stamp | None, ...]) -> float:
    return max((stamp[0] / 1e9 for stamp in stamps if stamp), default=0.0)


def _stamp(path: Path) -> Stamp | None:
    """Return what differs once a file has changed; None where there is no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


class HistoryBuffer:
    """A run's history in memory, to which rows are added in constant time.

    Args:
        rows: to begin with, from generation 1 on.
    """

    def __init__(self, rows: Rows | None = None) -> None:
        self._columns: Columns = {}
        self._length = 0
        if rows:
            self.extend(rows)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """A column, (generations,); not to be written to."""
        return self._columns[name][: self._length]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    @property
    def terms(self) -> list[str]:
        """The names of the terms, in the order in which they came."""
        return [name for name in self._columns if MEAN + name in self._columns]

    @property
    def figures(self) -> list[str]:
        """The names of the figures of the search."""
        return figures_of(self._columns)

    def extend(self, rows: Rows) -> bool:
        """Add rows, without those that are here already; those from generation 1 on replace all.

        Returns:
            Whether they follow those that are here. If not, nothing is added: rows are missing.
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
