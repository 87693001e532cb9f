"""The layout of a heat map in a picture of characters."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.ticks import labels, ticks

MIN_SIZE = 14, 5  # minimum columns and rows of a map
_BELOW = 4  # rows below the cells: the axis, its numbers, its name, the colour scale
_MIN_FILLED = 0.7  # share of the space that equal cells must fill; otherwise they differ by a dot


@dataclass(frozen=True, eq=False)
class Area:
    """The layout of a map in a picture of characters.

    Attributes:
        columns: width of the picture.
        rows: height of the picture.
        ends: low and high end of the axes, horizontal and vertical, (axes, 2).
        shaded: whether the map has shades of grey, one dot per character, instead of colours,
            two dots per character.
    """

    columns: int
    rows: int
    ends: NDArray[np.float64]
    shaded: bool = False

    @property
    def fits(self) -> bool:
        """Whether the picture has enough space for a map."""
        return (
            self.columns - self.left - 1 >= MIN_SIZE[0] // 2 and self.rows >= MIN_SIZE[1] + _BELOW
        )

    @property
    def high(self) -> int:
        """Dots per character, vertically."""
        return 1 if self.shaded else 2

    @property
    def height(self) -> int:
        """Rows of characters available for cells; the row above holds the name of the axis."""
        return self.rows - 1 - _BELOW

    @property
    def room(self) -> tuple[int, int]:
        """Maximum number of cells, across and up."""
        return self.columns - self.left - 1, self.height * self.high

    @property
    def left(self) -> int:
        """Columns to the left of the cells."""
        return max(len(word) for _, word in self.numbers) + 1 if self.numbers else 1

    @cached_property
    def numbers(self) -> list[tuple[float, str]]:
        """The numbers along the vertical axis, as values and strings."""
        most = max(min(self.height // 3, 6), 2)
        return numbers_along(self.ends[1], most) if len(self.ends) > 1 else []


def dots_of(cells: int, room: int) -> NDArray[np.intp]:
    """Return the borders of cells in `room` dots, (cells + 1,).

    The cells are equal if equal cells fill most of the room.
    """
    each = room // cells
    filled = each * cells if each * cells >= _MIN_FILLED * room else room
    return np.round(np.linspace(0, filled, cells + 1)).astype(np.intp)


def numbers_along(ends: NDArray[np.float64], most: int) -> list[tuple[float, str]]:
    """Return at most `most` round numbers between two ends, as values and strings."""
    values = ticks(float(ends[0]), float(ends[1]), most)
    return list(zip(values.tolist(), labels(values), strict=True))
