"""Files that grow by whole records, and are truncated to the checkpoint when a run is resumed."""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.history import (
    header,
    islands_header,
    line,
    read_header,
    read_history,
    terms_of,
    used_terms,
)

WHOLE = ("generation", "stage", "evaluations")  # columns of whole numbers


class AppendOnlyFile:
    """A file that grows by whole records and can be cut back."""

    def __init__(self, path: Path, keep: int) -> None:
        """Open `path` for appending after its first `keep` bytes."""
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        os.ftruncate(self._descriptor, keep)
        os.lseek(self._descriptor, 0, os.SEEK_END)

    def append(self, data: bytes, *, force: bool = True) -> None:
        """Add a record, and force it to disk."""
        view = memoryview(data)
        while view:
            view = view[os.write(self._descriptor, view) :]
        if force:
            os.fsync(self._descriptor)

    def close(self) -> None:
        """Close the file; once more does no harm."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1


class AppendOnlyIslands:
    """A run's `islands.csv`, opened for writing; without islands there is no such file.

    Args:
        path: the file.
        islands: how many there are.
        ends: where its lines end that are to be kept, as for `AppendOnlyHistory`.
    """

    def __init__(self, path: Path, islands: int, ends: Sequence[int]) -> None:
        self._islands = islands
        self._file = AppendOnlyFile(path, ends[-1] if ends else 0) if islands > 1 else None
        self._begins = "" if ends else line(islands_header(islands))

    def append(self, number: int, bests: NDArray[np.float64]) -> None:
        """Add a generation's best score of each island, (islands,), and force it to disk."""
        if self._file is not None:
            self._file.append((self._begins + line([number, *bests.tolist()])).encode())
            self._begins = ""

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()


def padded(path: Path, count: int, size: int) -> AppendOnlyFile:
    """A file of records of `size` bytes, opened after `count` of them; missing ones are zeros."""
    stored = path.stat().st_size // size if path.exists() else 0
    file = AppendOnlyFile(path, min(stored, count) * size)
    missing = count - stored
    if missing > 0:
        file.append(bytes(missing * size))
    return file


class AppendOnlyHistory:
    """A run's `history.csv`, opened for writing.

    The terms of a new stage get columns of their own. Its rows before and after, which
    do not have those terms, hold `nan` there.

    Args:
        path: the file.
        ends: where its lines end that are to be kept, in bytes: the header's, then a row's
            each; [] starts an empty file.
    """

    def __init__(self, path: Path, ends: Sequence[int]) -> None:
        self._path = path
        self._file = AppendOnlyFile(path, ends[-1] if ends else 0)
        self._terms: list[str] | None = None  # those of the rows that this process wrote
        self._columns: tuple[str, ...] = ()

    def append(self, values: Mapping[str, float]) -> None:
        """Add a generation's row, as `history.row` makes it, and force it to disk.

        Raises:
            RunError: the rows before cannot be read, or not be written with more columns.
        """
        terms = terms_of(values)
        begins = ""
        if terms != self._terms:
            begins = self._prepare(terms)
        row = line([values.get(name, math.nan) for name in self._columns])
        self._file.append((begins + row).encode())
        self._terms = terms

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _prepare(self, terms: Sequence[str]) -> str:
        """Give the file columns for these terms; returns the header of a file that is empty."""
        found = read_header(self._path)
        self._columns = header(terms)
        if found == self._columns:
            return ""
        if not found:
            return line(self._columns)
        before = read_history(self._path)
        self._columns = header(used_terms(before, terms))
        if found != self._columns:
            # Closed first: a file that is open cannot be replaced on every system.
            self._file.close()
            data = _table(before, self._columns).encode()
            write_bytes(self._path, data)
            self._file = AppendOnlyFile(self._path, len(data))
        return ""


def _table(before: Mapping[str, NDArray[np.float64]], columns: Sequence[str]) -> str:
    """A history's rows under these columns; `nan` where it does not have one."""
    missing = [math.nan] * len(before["generation"])
    cells: list[list[float]] = []
    for name in columns:
        values = before[name].tolist() if name in before else missing
        cells.append([int(value) for value in values] if name in WHOLE else values)
    return "".join([line(columns), *map(line, zip(*cells, strict=True))])
