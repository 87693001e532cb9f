"""Common parts of pictures of members along axes: layout, axes, colours, legend, cursor."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from unicodedata import combining, east_asian_width

import numpy as np
from numpy.typing import NDArray

from gaitsim.individual import Individual
from gaitsim.render.archive_view import colour_scale_low
from gaitsim.render.terminal.braille import Inks, Paper
from gaitsim.render.terminal.text import number, visible
from gaitsim.render.ticks import labels, ticks

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
# Levels of points and lines, which have to be visible on the background.
ON_DARK, ON_LIGHT, ON_ANY = range(4, LEVELS + 1), range(1, LEVELS - 2), range(3, LEVELS - 1)
POINTER = "#ff2d95"  # a colour absent from viridis, visible on dark and on light
SHADES = "·░▒▓█"  # an empty cell, and the levels of a scale without colours


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


def inks_of(values: NDArray[np.float64], scale: ColourScale, levels: range) -> Inks:
    """Return the ink of a point or a line for each value; the lowest one for NaN."""
    found = np.maximum(scale.levels(values, len(levels)), 1) - 1 + levels[0]
    return (FIRST + found * KINDS).astype(np.uint8)


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


MIN_SIZE = 14, 5  # minimum columns and rows of a picture
_BELOW = 4  # rows below the members: the axis, its numbers, its name, the legend
_MAX_LEVEL_WIDTH = 3  # maximum columns per level in the colour scale

Codes = NDArray[np.uint32]
Place = tuple[int, ...]
"""A place at which the cursor can be, such as a column and a row of cells."""


@dataclass(frozen=True, eq=False)
class PictureArea:
    """The layout of a picture of characters.

    Attributes:
        columns: width of the picture.
        rows: height of the picture.
        ends: low and high end of the axes, horizontal and vertical, (axes, 2).
        shaded: whether the picture has shades of grey, one dot per character, instead of colours,
            two dots per character.
    """

    columns: int
    rows: int
    ends: NDArray[np.float64]
    shaded: bool = False

    @property
    def fits(self) -> bool:
        """Whether the picture has enough space."""
        return (
            self.columns - self.left - 1 >= MIN_SIZE[0] // 2 and self.rows >= MIN_SIZE[1] + _BELOW
        )

    @property
    def high(self) -> int:
        """Dots per character, vertically."""
        return 1 if self.shaded else 2

    @property
    def height(self) -> int:
        """Rows of characters available for members; the row above holds the name of the axis."""
        return self.rows - 1 - _BELOW

    @property
    def room(self) -> tuple[int, int]:
        """Maximum number of cells, across and up."""
        return self.columns - self.left - 1, self.height * self.high

    @property
    def left(self) -> int:
        """Columns to the left of the members."""
        return max(len(word) for _, word in self.numbers) + 1 if self.numbers else 1

    @cached_property
    def numbers(self) -> list[tuple[float, str]]:
        """The numbers along the vertical axis, as values and strings."""
        most = max(min(self.height // 3, 6), 2)
        return numbers_along(self.ends[1], most) if len(self.ends) > 1 else []


def numbers_along(ends: NDArray[np.float64], most: int) -> list[tuple[float, str]]:
    """Return at most `most` round numbers between two ends, as values and strings."""
    values = ticks(float(ends[0]), float(ends[1]), most)
    return list(zip(values.tolist(), labels(values), strict=True))


class MemberPicture(ABC):
    """A picture of members along one or two axes, with places for a cursor.

    Attributes:
        area: layout of the picture.
    """

    area: PictureArea

    @property
    def fits(self) -> bool:
        """Whether the picture has enough space."""
        return self.area.fits

    @abstractmethod
    def member(self, place: Place) -> int:
        """Return the number of the member at a place."""

    @abstractmethod
    def place_of(self, number: int) -> Place | None:
        """Return the place of a member, or one near it; None without members."""

    @abstractmethod
    def place_near(self, *values: float) -> Place | None:
        """Return the place nearest to a value along each axis; None without members."""

    @abstractmethod
    def place_at(self, column: int, row: int) -> Place | None:
        """Return the place nearest to a character; None outside the axes or without members."""

    @abstractmethod
    def place_beside(self, place: Place, across: int, up: int) -> Place:
        """Return the nearest place in a direction, or the same place if there is none.

        Args:
            place: place of the cursor.
            across: horizontal direction, −1, 0 or 1.
            up: vertical direction, −1, 0 or 1; 0 unless `across` is 0.
        """

    @abstractmethod
    def values_at(self, place: Place) -> tuple[float, ...]:
        """Return the value along each axis at a place."""

    @abstractmethod
    def draw(
        self, cursor: Place | None = None, marks: Mapping[Place, str] | None = None
    ) -> tuple[Codes, Inks]:
        """Draw the members, axes and legend, as code points and inks, both (rows, columns).

        Args:
            cursor: place of the cursor, which is marked on the axes as well.
            marks: characters, one column wide, to write at places.
        """

    def draw_axes(self, paper: Paper, wide: int, height: int, across: str, up: str) -> None:
        """Draw the frame of the members, the numbers and the names of the axes.

        Args:
            paper: the picture.
            wide: columns within the frame.
            height: rows within the frame.
            across: name of the horizontal axis.
            up: name of the vertical axis; '' for none.
        """
        area, bottom = self.area, 1 + height
        right = area.left + wide
        paper.write(0, max(area.left - 1, 0), up, AXIS)
        for row in range(1, bottom):
            paper.write(row, area.left - 1, "│", AXIS)
            paper.write(row, right, "│", AXIS)
        paper.write(bottom, area.left - 1, "└" + "─" * wide + "┘", AXIS)
        (x_low, x_high), (y_low, y_high) = area.ends[0].tolist(), area.ends[-1].tolist()
        for value, word in area.numbers:
            share = (value - y_low) / (y_high - y_low)
            row = bottom - 1 - min(int(share * height), height - 1)
            paper.write(row, area.left - 1 - len(word), word + "┤", AXIS)
        free = 0
        for value, word in numbers_along(area.ends[0], max(wide // 9, 2)):
            column = area.left + min(int((value - x_low) / (x_high - x_low) * wide), wide - 1)
            start = min(max(column - len(word) // 2, 0), area.columns - len(word))
            if start >= free:
                paper.write(bottom, column, "┬", AXIS)
                paper.write(bottom + 1, start, word, AXIS)
                free = start + len(word) + 1
        paper.write(bottom + 2, max(right - len(across), 0), across, AXIS)

    def draw_cursor(self, paper: Paper, row: int, column: int, height: int) -> None:
        """Mark the row and the column of the cursor on the axes."""
        paper.write(row, self.area.left - 1, "▸", CURSOR)
        paper.write(1 + height, column, "▴", CURSOR)

    def draw_scale(
        self,
        paper: Paper,
        row: int,
        title: str,
        scale: ColourScale,
        levels: range = range(1, LEVELS + 1),
    ) -> None:
        """Write a colour scale with the values at its ends."""
        area = self.area
        levels = range(1, len(SHADES)) if area.shaded else levels
        count = len(levels)
        low = ("≤" if scale.extended else "") + number(scale.low, 2)
        high = number(scale.high, 2)
        room = area.columns - len(low) - len(high) - 2
        each = min((room - len(title) - 1) // count, _MAX_LEVEL_WIDTH * LEVELS // count)
        name = f"{title} " if each else ""
        each = max(each, min(room // count, 1))
        paper.write(row, 0, f"{name}{low} ", AXIS)
        column = len(name) + len(low) + 1
        for level in levels if each else ():
            if area.shaded:
                paper.write(row, column, SHADES[level] * each, AXIS)
            else:
                paper.write(row, column, "█" * each, ink_of(level, level))
            column += each
        # A plain space would join the text before it and take its background colour.
        paper.write(row, column, f"\N{NO-BREAK SPACE}{high}", AXIS)


def next_ahead(away: NDArray[np.float64], across: int, up: int) -> int | None:
    """Return the index of the nearest position in a direction; None if there is none.

    Positions within 45 degrees of the direction are preferred.

    Args:
        away: positions relative to the cursor, (positions, 2), upwards positive.
        across: horizontal direction, −1, 0 or 1.
        up: vertical direction, −1, 0 or 1; 0 unless `across` is 0.
    """
    ahead, aside = away @ (across, up), np.abs(away @ (up, across))
    for within in (aside <= ahead, ahead > 0):
        chosen = np.flatnonzero((ahead > 0) & within)
        if len(chosen):
            # A position straight ahead is preferred to a nearer one beside the line.
            return int(chosen[np.argmin(ahead[chosen] + 2 * aside[chosen])])
    return None


def narrow(text: str) -> str:
    """Replace characters that are not one column wide."""
    return "".join(
        "?" if combining(char) or east_asian_width(char) in "WF" else char for char in visible(text)
    )


def units_of(individual: Individual, names: Iterable[str]) -> dict[str, str]:
    """Return the units of the score and of other values by name, as text for terminals."""
    return {name: visible(individual.unit_of(name)) for name in ("score", *names)}


def axis_labels(names: Iterable[str], units: Mapping[str, str]) -> dict[str, str]:
    """Return labels for the score and for axes by name, with units where they are known."""
    labelled = {name: units.get(name, "") for name in ("score", *names)}
    return {name: f"{name} ({unit})" if unit else name for name, unit in labelled.items()}
