"""A heat map of an archive's panel, in coloured half blocks or shades of grey."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.render import archive_view
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.braille import Inks, Paper
from gaitsim.render.terminal.member_picture import (
    AXIS,
    CURSOR,
    EMPTY,
    FIRST,
    KINDS,
    LEVELS,
    MARKED,
    NONE,
    POINTED,
    SHADES,
    Codes,
    ColourScale,
    MemberPicture,
    PictureArea,
    Place,
    narrow,
    next_ahead,
)
from gaitsim.render.terminal.text import number
from gaitsim.storage.files.history import FIGURE
from gaitsim.storage.snapshot import RunSnapshot

_MIN_FILLED = 0.7  # share of the space that equal cells must fill; otherwise they differ by a dot
_POINTED_SHADE = "◆"


def dots_of(cells: int, room: int) -> NDArray[np.intp]:
    """Return the borders of cells in `room` dots, (cells + 1,).

    The cells are equal if equal cells fill most of the room.
    """
    each = room // cells
    filled = each * cells if each * cells >= _MIN_FILLED * room else room
    return np.round(np.linspace(0, filled, cells + 1)).astype(np.intp)


Occupied = NDArray[np.bool_]


def next_occupied(occupied: Occupied, place: Place, across: int, up: int) -> Place:
    """Return the nearest occupied cell in a direction, or the same cell if there is none.

    Cells within 45 degrees of the direction are preferred.

    Args:
        occupied: whether each cell has an elite, (across, up).
        place: cell at which the cursor is.
        across: horizontal direction, −1, 0 or 1.
        up: vertical direction, −1, 0 or 1; 0 unless `across` is 0.
    """
    cells = np.argwhere(occupied)
    best = next_ahead(cells - np.array(place, float), across, up)
    return place if best is None else (int(cells[best, 0]), int(cells[best, 1]))


def nearest(occupied: Occupied, place: Place) -> Place | None:
    """Return the occupied cell nearest to a cell; None if all cells are empty."""
    cells = np.argwhere(occupied)
    if not len(cells):
        return None
    best = np.argmin(((cells - np.array(place)) ** 2).sum(1))
    return int(cells[best, 0]), int(cells[best, 1])


class HeatMap(MemberPicture):
    """A map of an archive along one or two axes.

    The colour of a cell shows the score of its best elite.

    Args:
        view: the archive.
        names: names of the axes, one or two.
        words: labels of the axes and of the score, with units, by name.
        columns: width of the picture.
        rows: height of the picture.
        shaded: whether to use shades of grey instead of colours.

    Attributes:
        numbers: number of the member in each cell, (across, up); `archive_view.EMPTY` in empty
            cells.
        borders: borders of the cells along each axis, (cells + 1,) each.
        scale: the colour scale.
    """

    def __init__(
        self,
        view: ArchiveView,
        names: tuple[str, ...],
        words: Mapping[str, str],
        columns: int,
        rows: int,
        *,
        shaded: bool = False,
    ) -> None:
        self._view, self._axes_shown = view, names
        self._names = tuple(narrow(words[name]) for name in names)
        self._score = narrow(words["score"])
        ends = np.array([view.borders[name][[0, -1]] for name in names])
        self.area = area = PictureArea(columns, rows, ends, shaded)
        wide, high = (max(one, 1) for one in area.room)
        panel = view.panel(*names, most=(wide, high))
        self.borders = panel.borders
        shape = panel.scores.shape[0], -1
        self._scores, self.numbers = panel.scores.reshape(shape), panel.members.reshape(shape)
        self.scale = ColourScale.of(self._scores)
        self._across = dots_of(self._scores.shape[0], wide)
        up = dots_of(self._scores.shape[1], high)
        # The cells fill whole characters, so that they touch the axis below.
        self._up = up + (-up[-1]) % area.high

    @property
    def occupied(self) -> Occupied:
        """Whether each cell has an elite, (across, up)."""
        return np.not_equal(self.numbers, archive_view.EMPTY)

    def member(self, place: Place) -> int:
        return int(self.numbers[place])

    def place_of(self, number: int) -> Place:
        """Return a cell that shows a member, or else the cell that contains it."""
        values = [float(self._view.members.values[name][number - 1]) for name in self._axes_shown]
        place = self.cell_of(*values)
        return nearest(self.numbers == number, place) or place

    def cell_of(self, *values: float) -> Place:
        """Return the cell at a value along each axis, clipped to the ends of the axes."""
        i, j, *_ = (
            *(
                int(np.searchsorted(borders[1:-1], value, side="right"))
                for borders, value in zip(self.borders, values, strict=True)
            ),
            0,
        )
        return i, j

    def place_near(self, *values: float) -> Place | None:
        return nearest(self.occupied, self.cell_of(*values))

    def place_at(self, column: int, row: int) -> Place | None:
        cell = self.cell_at(column, row)
        return None if cell is None else nearest(self.occupied, cell)

    def place_beside(self, place: Place, across: int, up: int) -> Place:
        return next_occupied(self.occupied, place, across, up)

    def values_at(self, place: Place) -> tuple[float, ...]:
        """Return the value along each axis at the middle of a cell."""
        return tuple(
            float(borders[at] + borders[at + 1]) / 2
            for borders, at in zip(self.borders, place, strict=False)
        )

    @property
    def _height(self) -> int:
        return int(self._up[-1]) // self.area.high

    def cell_at(self, column: int, row: int) -> Place | None:
        """Return the cell at a character of the picture; None outside the cells."""
        area = self.area
        across, up = column - area.left, (1 + self._height - row) * area.high - 1
        if not (0 <= across < self._across[-1] and self._up[0] <= up < self._up[-1]):
            return None
        i = int(np.searchsorted(self._across, across, side="right")) - 1
        j = int(np.searchsorted(self._up, up, side="right")) - 1
        return i, j

    def draw(
        self, cursor: Place | None = None, marks: Mapping[Place, str] | None = None
    ) -> tuple[Codes, Inks]:
        area, paper = self.area, Paper.blank(self.area.columns, self.area.rows)
        codes, inks = paper.codes, paper.inks
        if not area.fits:
            return codes, inks
        levels = self.scale.levels(self._scores, len(SHADES) - 1 if area.shaded else LEVELS)
        drawn = np.repeat(np.repeat(levels, np.diff(self._across), 0), np.diff(self._up), 1)
        if cursor is not None:
            (left, right), (low, high) = (
                ends[at : at + 2] for ends, at in zip((self._across, self._up), cursor, strict=True)
            )
            within = drawn[left + 1 : right - 1, low + 1 : high - 1].copy()
            drawn[left:right, low:high] = POINTED
            drawn[left + 1 : right - 1, low + 1 : high - 1] = within
        dots = np.full((self._height * area.high, int(self._across[-1])), NONE)
        dots[: drawn.shape[1]] = drawn.T[::-1]
        inside = (slice(1, 1 + self._height), slice(area.left, area.left + dots.shape[1]))
        codes[inside], inks[inside] = _shades(dots) if area.shaded else _blocks(dots)
        for (i, j), mark in (marks or {}).items():
            row, column = self._middle(i, j)
            level = levels[i, j] if not area.shaded else NONE
            paper.write(row, column, mark[:1], MARKED + int(level))
        up = f"↑ {self._names[1]}" if len(self._names) > 1 else ""
        self.draw_axes(paper, dots.shape[1], self._height, f"{self._names[0]} →", up)
        if cursor is not None:
            self.draw_cursor(paper, *self._middle(*cursor), self._height)
        self.draw_scale(paper, 4 + self._height, self._score, self.scale)
        return codes, inks

    def _middle(self, i: int, j: int) -> tuple[int, int]:
        """Return the row and the column of the middle of a cell."""
        across = (self._across[i] + self._across[i + 1] - 1) // 2
        up = (self._up[j] + self._up[j + 1] - 1) // 2
        return self._height - int(up) // self.area.high, self.area.left + int(across)


def _blocks(dots: NDArray[np.intp]) -> tuple[Codes, Inks]:
    """Return half blocks and the inks of both halves, for dots (2 × rows, columns)."""
    upper, lower = dots[::2], dots[1::2]
    alike = [(upper == NONE) & (lower == NONE), upper == lower, upper == NONE]
    codes = np.select(alike, [ord(SHADES[0]), ord("█"), ord("▄")], ord("▀"))
    inks = np.where(alike[0], EMPTY, FIRST + upper * KINDS + lower)
    return codes.astype(np.uint32), inks.astype(np.uint8)


def _shades(dots: NDArray[np.intp]) -> tuple[Codes, Inks]:
    signs = np.array([ord(sign) for sign in SHADES.ljust(POINTED) + _POINTED_SHADE])
    inks = np.select([dots == POINTED, dots == NONE], [CURSOR, EMPTY], AXIS)
    return signs[dots].astype(np.uint32), inks.astype(np.uint8)


def summary(run: RunSnapshot, view: ArchiveView) -> str:
    """Return generation, elites, coverage and, if the search records it, the QD score."""
    score = run.history.get(f"{FIGURE}QD score")
    parts = [
        f"generation {run.generation:,}",
        view.coverage,
        *([f"QD score {number(float(score[-1]), 1)}"] if score is not None else []),
    ]
    return "  ".join(parts)
