"""Where the cells of a heat map are in a picture of characters."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.ticks import labels, ticks

LEAST = 14, 5  # columns and rows that a map takes at least
_BELOW = 4  # rows below the cells: the axis, its numbers, its name, the colour scale
_ENOUGH = 0.7  # share of its room that a map of equal cells fills, else they differ by a dot


@dataclass(frozen=True, eq=False)
class Area:
    """Where the cells of a map are in a picture of characters.

    Attributes:
        columns: of the picture.
        rows: of the picture.
        ends: low and high end of the axes, across and up, (axes, 2).
        shaded: whether it has no colours; then a character is one dot, else two.
    """

    columns: int
    rows: int
    ends: NDArray[np.float64]
    shaded: bool = False

    @property
    def fits(self) -> bool:
        """Whether there is room for a map."""
        return self.columns - self.left - 1 >= LEAST[0] // 2 and self.rows >= LEAST[1] + _BELOW

    @property
    def high(self) -> int:
        """Dots of a character's height."""
        return 1 if self.shaded else 2

    @property
    def height(self) -> int:
        """Rows of characters that the cells may take; one above has the name of the axis."""
        return self.rows - 1 - _BELOW

    @property
    def room(self) -> tuple[int, int]:
        """The most cells that have room, across and up."""
        return self.columns - self.left - 1, self.height * self.high

    @property
    def left(self) -> int:
        """Columns in front of the cells."""
        return max(len(word) for _, word in self.numbers) + 1 if self.numbers else 1

    @cached_property
    def numbers(self) -> list[tuple[float, str]]:
        """The numbers along the axis up."""
        most = max(min(self.height // 3, 6), 2)
        return numbers_along(self.ends[1], most) if len(self.ends) > 1 else []


def dots_of(cells: int, room: int) -> NDArray[np.intp]:
    """Return where cells begin and the last one ends in so many dots, (cells + 1,).

    They are equal where this fills most of the room.
    """
    each = room // cells
    filled = each * cells if each * cells >= _ENOUGH * room else room
    return np.round(np.linspace(0, filled, cells + 1)).astype(np.intp)


def numbers_along(ends: NDArray[np.float64], most: int) -> list[tuple[float, str]]:
    """Return at most so many round numbers between two ends, and how they are written."""
    values = ticks(float(ends[0]), float(ends[1]), most)
    return list(zip(values.tolist(), labels(values), strict=True))
