"""A heat map of an archive's panel, in coloured half blocks or shades of grey."""

from collections.abc import Mapping
from dataclasses import dataclass
from unicodedata import combining, east_asian_width

import numpy as np
from numpy.typing import NDArray

from gaitsim.render import archive_view
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.braille import SPACE, Inks
from gaitsim.render.terminal.cell_steps import Occupied, Place, nearest
from gaitsim.render.terminal.colour_scale import (
    AXIS,
    CURSOR,
    EMPTY,
    FIRST,
    KINDS,
    LEVELS,
    MARKED,
    NONE,
    POINTED,
    Scale,
    ink_of,
)
from gaitsim.render.terminal.map_area import Area, dots_of, numbers_along
from gaitsim.render.terminal.text import number, visible

Codes = NDArray[np.uint32]
SHADES = "·░▒▓█"  # an empty cell, and the levels of a scale without colours
_POINTED_SHADE = "◆"
_MAX_LEVEL_WIDTH = 3  # maximum columns per level in the colour scale


class HeatMap:
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
        self._names = tuple(_narrow(words[name]) for name in names)
        self._score = _narrow(words["score"])
        ends = np.array([view.borders[name][[0, -1]] for name in names])
        self._area = area = Area(columns, rows, ends, shaded)
        wide, high = (max(one, 1) for one in area.room)
        panel = view.panel(*names, most=(wide, high))
        self.borders = panel.borders
        shape = panel.scores.shape[0], -1
        self._scores, self.numbers = panel.scores.reshape(shape), panel.members.reshape(shape)
        self.scale = Scale.of(self._scores)
        self._across = dots_of(self._scores.shape[0], wide)
        up = dots_of(self._scores.shape[1], high)
        # The cells fill whole characters, so that they touch the axis below.
        self._up = up + (-up[-1]) % area.high

    @property
    def fits(self) -> bool:
        """Whether the picture has enough space for a map."""
        return self._area.fits

    @property
    def occupied(self) -> Occupied:
        """Whether each cell has an elite, (across, up)."""
        return np.not_equal(self.numbers, archive_view.EMPTY)

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

    def middle_of(self, place: Place) -> tuple[float, ...]:
        """Return the value along each axis at the middle of a cell."""
        return tuple(
            float(borders[at] + borders[at + 1]) / 2
            for borders, at in zip(self.borders, place, strict=False)
        )

    @property
    def _height(self) -> int:
        return int(self._up[-1]) // self._area.high

    def cell_at(self, column: int, row: int) -> Place | None:
        """Return the cell at a character of the picture; None outside the cells."""
        area = self._area
        across, up = column - area.left, (1 + self._height - row) * area.high - 1
        if not (0 <= across < self._across[-1] and self._up[0] <= up < self._up[-1]):
            return None
        i = int(np.searchsorted(self._across, across, side="right")) - 1
        j = int(np.searchsorted(self._up, up, side="right")) - 1
        return i, j

    def draw(
        self, cursor: Place | None = None, marks: dict[Place, str] | None = None
    ) -> tuple[Codes, Inks]:
        """Draw the map, its axes and the scale, as code points and inks, both (rows, columns).

        Args:
            cursor: cell at the cursor, which is marked on the axes as well.
            marks: characters, one column wide, to write on cells.
        """
        area = self._area
        codes = np.full((area.rows, area.columns), SPACE, dtype=np.uint32)
        inks = np.zeros((area.rows, area.columns), dtype=np.uint8)
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
        paper = _Paper(codes, inks)
        inside = (slice(1, 1 + self._height), slice(area.left, area.left + dots.shape[1]))
        codes[inside], inks[inside] = _shades(dots) if area.shaded else _blocks(dots)
        for (i, j), mark in (marks or {}).items():
            row, column = self._middle(i, j)
            level = levels[i, j] if not area.shaded else NONE
            paper.write(row, column, mark[:1], MARKED + int(level))
        self._axes(paper)
        if cursor is not None:
            row, column = self._middle(*cursor)
            paper.write(row, area.left - 1, "▸", CURSOR)
            paper.write(1 + self._height, column, "▴", CURSOR)
        self._legend(paper)
        return codes, inks

    def _middle(self, i: int, j: int) -> tuple[int, int]:
        """Return the row and the column of the middle of a cell."""
        across = (self._across[i] + self._across[i + 1] - 1) // 2
        up = (self._up[j] + self._up[j + 1] - 1) // 2
        return self._height - int(up) // self._area.high, self._area.left + int(across)

    def _axes(self, paper: "_Paper") -> None:
        area, bottom = self._area, 1 + self._height
        wide = int(self._across[-1])
        right = area.left + wide
        if len(self._names) > 1:
            paper.write(0, max(area.left - 1, 0), f"↑ {self._names[1]}")
        for row in range(1, bottom):
            paper.write(row, area.left - 1, "│")
            paper.write(row, right, "│")
        paper.write(bottom, area.left - 1, "└" + "─" * wide + "┘")
        (x_low, x_high), (y_low, y_high) = area.ends[0].tolist(), area.ends[-1].tolist()
        for value, word in area.numbers:
            share = (value - y_low) / (y_high - y_low)
            row = bottom - 1 - min(int(share * self._height), self._height - 1)
            paper.write(row, area.left - 1 - len(word), word + "┤")
        free = 0
        for value, word in numbers_along(area.ends[0], max(wide // 9, 2)):
            column = area.left + min(int((value - x_low) / (x_high - x_low) * wide), wide - 1)
            start = min(max(column - len(word) // 2, 0), area.columns - len(word))
            if start >= free:
                paper.write(bottom, column, "┬")
                paper.write(bottom + 1, start, word)
                free = start + len(word) + 1
        name = f"{self._names[0]} →"
        paper.write(bottom + 2, max(right - len(name), 0), name)

    def _legend(self, paper: "_Paper") -> None:
        """Write the colour scale with the scores at its ends."""
        area, scale = self._area, self.scale
        count = len(SHADES) - 1 if area.shaded else LEVELS
        low = ("≤" if scale.extended else "") + number(scale.low, 2)
        high = number(scale.high, 2)
        room = area.columns - len(low) - len(high) - 2
        each = min((room - len(self._score) - 1) // count, _MAX_LEVEL_WIDTH * LEVELS // count)
        name = f"{self._score} " if each else ""
        each = max(each, min(room // count, 1))
        row = 4 + self._height
        paper.write(row, 0, f"{name}{low} ")
        column = len(name) + len(low) + 1
        for level in range(1, count + 1) if each else ():
            if area.shaded:
                paper.write(row, column, SHADES[level] * each)
            else:
                paper.write(row, column, "█" * each, ink_of(level, level))
            column += each
        # A plain space would join the text before it and take its background colour.
        paper.write(row, column, f"\N{NO-BREAK SPACE}{high}")


@dataclass(frozen=True, eq=False)
class _Paper:
    codes: Codes
    inks: Inks

    def write(self, row: int, column: int, text: str, ink: int = AXIS) -> None:
        text = text[: max(self.codes.shape[1] - column, 0)]
        self.codes[row, column : column + len(text)] = [ord(one) for one in text]
        self.inks[row, column : column + len(text)] = ink


def _narrow(text: str) -> str:
    """Replace characters that are not one column wide."""
    return "".join(
        "?" if combining(char) or east_asian_width(char) in "WF" else char for char in visible(text)
    )


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
