"""The rows of a history that were added since it was last read."""

import csv
from pathlib import Path

import numpy as np

from gaitsim.errors import RunError
from gaitsim.live.course import Rows
from gaitsim.runs.files.history import COLUMNS


class Tail:
    """Reads a growing `history.csv` further and further, each row once.

    Where the file was written anew, as for the terms of a new stage, all of it comes again.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._head, self._offset, self._next = b"", 0, 1

    def read(self, until: int) -> Rows:
        """The columns of the rows that are new, up to a generation; {} where there are none.

        Raises:
            RunError: the file cannot be read, or is no history.
        """
        try:
            with self._path.open("rb") as file:
                head = file.readline()
                length = file.seek(0, 2)
                if head != self._head or length < self._offset:
                    self._head, self._offset, self._next = head, len(head), 1
                file.seek(self._offset)
                lines = file.read().split(b"\n")[:-1]
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise RunError(f"cannot read {self._path}: {error.strerror}") from None
        lines = lines[: max(until + 1 - self._next, 0)]
        if not lines:
            return {}
        try:
            names = next(csv.reader([head.decode()]))
            table = np.loadtxt([line.decode() for line in lines], delimiter=",", ndmin=2)
        except (UnicodeDecodeError, ValueError, StopIteration, csv.Error):
            raise self._damaged() from None
        numbers = np.arange(self._next, self._next + len(lines))
        fits = tuple(names[: len(COLUMNS)]) == COLUMNS and table.shape == (len(lines), len(names))
        if not fits or not np.array_equal(table[:, 0], numbers):
            raise self._damaged()
        self._offset += sum(len(line) + 1 for line in lines)
        self._next += len(lines)
        return {name: table[:, column] for column, name in enumerate(names)}

    def _damaged(self) -> RunError:
        return RunError(
            f"{self._path.name} is damaged: it does not hold a row of numbers a generation",
            where=str(self._path),
            remedy="restore it from a copy; the checkpoint beside it is separate",
        )
