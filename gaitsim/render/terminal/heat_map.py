"""A heat map of an archive's panel, in coloured half blocks or shades of grey."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from unicodedata import combining, east_asian_width

import numpy as np
from numpy.typing import NDArray

from gaitsim.individual import Individual
from gaitsim.render import archive_view
from gaitsim.render.archive_view import ArchiveView, colour_scale_low
from gaitsim.render.terminal.braille import SPACE, Inks
from gaitsim.render.terminal.text import number, visible
from gaitsim.render.ticks import labels, ticks
from gaitsim.storage.files.history import FIGURE
from gaitsim.storage.snapshot import RunSnapshot

AXIS, CURSOR, EMPTY = 1, 2, 3  # inks of axes and labels, of the cursor on the axes, of empty cells
LEVELS = 13  # levels of the scale; all pairs of levels, empty and cursor have inks in one byte
NONE, POINTED = 0, LEVELS + 1  # levels of an empty cell, and of the cell under the cursor
KINDS = LEVELS + 2
FIRST = 4
MARKED = FIRST + KINDS * KINDS

# Viridis, by Smith and van der Walt (2015), in equal steps.
VIRIDIS = (
    "#440154", "#481f70", "#443983", "#3b528b", "#31688e", "#287c8e", "#21918c",
    "#20a486", "#35b779", "#5ec962", "#90d743", "#c8e020", "#fde725",
)  # fmt: skip
POINTER = "#ff2d95"  # a colour absent from viridis, visible on dark and on light


@dataclass(frozen=True)
class ColourScale:
    """A linear scale from scores to levels of colour.

    Attributes:
        low: score at the low end of the scale.
        high: score at the high end of the scale.
        extended: whether some scores are below `low`.
    """

    low: float
    high: float
    extended: bool = False

    @classmethod
    def of(cls, scores: NDArray[np.float64]) -> "ColourScale":
        """Return the scale for scores, NaN if missing; a few very low scores may be below it."""
        known = scores[np.isfinite(scores)]
        if not len(known):
            return cls(0.0, 1.0)
        low, extended = colour_scale_low(known)
        return cls(low, float(known.max()), extended)

    def levels(self, scores: NDArray[np.float64], count: int) -> NDArray[np.intp]:
        """Return the level of each score, 1 to `count`; 0 for NaN."""
        share = (scores - self.low) / max(self.high - self.low, 1e-12)
        found = np.clip(np.nan_to_num(share * count, nan=0.0), 0, count - 1).astype(np.intp) + 1
        return np.where(np.isfinite(scores), found, NONE)


def ink_of(upper: int, lower: int) -> int:
    """Return the ink of a character whose halves have these levels."""
    return FIRST + upper * KINDS + lower


def styles(axis: str, empty: str, pointer: str = POINTER) -> list[str]:
    """Return the style of each ink as 'colour on background', in Rich's syntax.

    Args:
        axis: colour of axes and labels.
        empty: colour of empty cells.
        pointer: colour of the cursor.
    """
    levels = [*VIRIDIS, pointer]
    alone = ["", *levels]
    pairs = [
        f"{upper} on {lower}" if upper and lower else upper or lower
        for upper in alone
        for lower in alone
    ]
    dark, light = "bold #000000", "bold #ffffff"
    marked = [
        f"{dark if 2 * level > LEVELS else light} on {paint}"
        for level, paint in enumerate(levels, start=1)
    ]
    return [axis, axis, pointer, empty, *pairs, f"bold {axis}", *marked]


MIN_SIZE = 14, 5  # minimum columns and rows of a map
_BELOW = 4  # rows below the cells: the axis, its numbers, its name, the colour scale
_MIN_FILLED = 0.7  # share of the space that equal cells must fill; otherwise they differ by a dot


@dataclass(frozen=True, eq=False)
class MapArea:
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


Place = tuple[int, int]
"""The column and the row of a panel's cell, from the low ends of its axes."""
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
    away = cells - np.array(place)
    ahead, aside = away @ (across, up), np.abs(away @ (up, across))
    for within in (aside <= ahead, ahead > 0):
        chosen = np.flatnonzero((ahead > 0) & within)
        if len(chosen):
            # A cell straight ahead is preferred to a nearer cell beside the line.
            best = chosen[np.argmin(ahead[chosen] + 2 * aside[chosen])]
            return int(cells[best, 0]), int(cells[best, 1])
    return place


def nearest(occupied: Occupied, place: Place) -> Place | None:
    """Return the occupied cell nearest to a cell; None if all cells are empty."""
    cells = np.argwhere(occupied)
    if not len(cells):
        return None
    best = np.argmin(((cells - np.array(place)) ** 2).sum(1))
    return int(cells[best, 0]), int(cells[best, 1])


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
        self._area = area = MapArea(columns, rows, ends, shaded)
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


def axis_labels(individual: Individual, view: ArchiveView) -> dict[str, str]:
    """Return labels with units for the score and the axes of an archive, by name."""
    units = {name: individual.unit_of(name) for name in ("score", *view.names)}
    return {name: f"{name} ({unit})" if unit else name for name, unit in units.items()}


def summary(run: RunSnapshot, view: ArchiveView) -> str:
    """Return generation, elites, coverage and, if the search records it, the QD score."""
    score = run.history.get(f"{FIGURE}QD score")
    parts = [
        f"generation {run.generation:,}",
        view.coverage,
        *([f"QD score {number(float(score[-1]), 1)}"] if score is not None else []),
    ]
    return "  ".join(parts)
