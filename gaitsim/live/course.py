"""A run's history in memory, as it grows."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.history import COLUMNS, MEAN

Rows = Mapping[str, NDArray[np.float64]]


class Course:
    """Columns by name, (generations,) each, that rows are added to in constant time.

    Args:
        rows: to begin with, from generation 1 on.
    """

    def __init__(self, rows: Rows | None = None) -> None:
        self._columns: dict[str, NDArray[np.float64]] = {}
        self._length = 0
        if rows:
            self.extend(rows)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """A column; not to be kept or written to."""
        return self._columns[name][: self._length]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    @property
    def terms(self) -> list[str]:
        """The names of the terms, in the order in which they came."""
        return [name for name in self._columns if MEAN + name in self._columns]

    def extend(self, rows: Rows) -> bool:
        """Add rows; those that are there already are passed over.

        Returns:
            Whether they follow on. If not, nothing is added: the history is to be read anew.
        """
        numbers = rows.get(COLUMNS[0])
        if numbers is None or not len(numbers):
            return True
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
