"""Drawing in braille characters, whose cells have 2 × 4 dots.

A picture is an array (rows × 4, columns × 2) of dots, each with the number of an ink, or 0.
Where two inks meet, the higher one wins, so the order of drawing does not matter. A cell of a
terminal has only one colour: the colour of its highest ink applies to all its dots. The
dots of the ground behind a body are left out, as they would thicken the body.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Dots = NDArray[np.uint8]
Inks = NDArray[np.uint8]
Points = NDArray[np.float64]

WIDE, HIGH = 2, 4  # dots per cell
SPACE = ord(" ")
EMPTY = 0x2800
# Decimals to which dots are rounded: results that differ in the last bit between computers give
# the same picture.
_DECIMALS = 3
# The bit of each dot in a character (Unicode, Braille Patterns).
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], dtype=np.uint32)


def empty(columns: int, rows: int) -> Dots:
    """Return an empty picture of `columns` × `rows` cells."""
    return np.zeros((max(rows, 0) * HIGH, max(columns, 0) * WIDE), dtype=np.uint8)


def draw_points(dots: Dots, points: Points, inks: int | NDArray[Any]) -> None:
    """Draw points (n, 2), in dots from the upper left corner; points outside are ignored."""
    height, width = dots.shape
    at = np.rint(np.round(points, _DECIMALS)).astype(np.intp)
    inside = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    at = at[inside]
    each = np.broadcast_to(np.asarray(inks, dtype=np.uint8), len(points))
    np.maximum.at(dots, (at[:, 1], at[:, 0]), each[inside])


def draw_lines(
    dots: Dots, ends: Points, inks: NDArray[Any], dash: tuple[int, int] = (1, 0)
) -> None:
    """Draw lines, clipped to the picture.

    All lines are drawn at once, sampled at each dot of their longer side.

    Args:
        dots: the picture, modified in place.
        ends: ends of the lines, (n, 2, 2).
        inks: ink of each line, (n,).
        dash: number of dots drawn and number left out in turn, continued from line to line.
    """
    finite = np.isfinite(ends).all(axis=(1, 2))
    ends, inks = np.round(ends[finite], _DECIMALS), inks[finite]
    lengths = np.abs(ends[:, 1] - ends[:, 0]).max(axis=1)
    before = np.cumsum(lengths) - lengths
    ends, kept = _clip(ends, *dots.shape)
    if not len(ends):
        return
    along = ends[:, 1] - ends[:, 0]
    counts = np.ceil(np.abs(along).max(axis=1)).astype(np.intp) + 1
    line = np.repeat(np.arange(len(ends)), counts)
    step = np.arange(len(line)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = step / np.maximum(counts - 1, 1)[line]
    points, ink = ends[line, 0] + share[:, None] * along[line], inks[kept][line]
    if dash[1]:
        shown = np.rint(before[kept][line] + step) % sum(dash) < dash[0]
        points, ink = points[shown], ink[shown]
    draw_points(dots, points, ink)


def _clip(ends: Points, height: int, width: int) -> tuple[Points, NDArray[np.bool_]]:
    """Clip lines to a picture (Liang and Barsky 1984); return these and which lines are visible."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    first, last = np.zeros(len(ends)), np.ones(len(ends))
    kept = np.ones(len(ends), dtype=np.bool_)
    for axis, most in ((0, width - 1.0), (1, height - 1.0)):
        for sign, room in ((-1.0, start[:, axis]), (1.0, most - start[:, axis])):
            slope = sign * along[:, axis]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                cut = room / slope
            first = np.where(slope < 0, np.maximum(first, cut), first)
            last = np.where(slope > 0, np.minimum(last, cut), last)
            kept &= (slope != 0) | (room >= 0)
    kept &= first <= last
    first, last = first[kept, None], last[kept, None]
    return np.stack([start[kept] + first * along[kept], start[kept] + last * along[kept]], 1), kept


def cells(dots: Dots, behind: int = 0) -> tuple[NDArray[np.uint32], Inks]:
    """Return the code point and the ink of each cell, both (rows, columns).

    Args:
        dots: the picture.
        behind: highest ink of the background, which is left out of cells with a higher ink.
    """
    rows, columns = dots.shape[0] // HIGH, dots.shape[1] // WIDE
    grouped = dots.reshape(rows, HIGH, columns, WIDE).transpose(0, 2, 1, 3)
    inks = grouped.max(axis=(2, 3), initial=0)
    least = np.where(inks > behind, behind + 1, 1)[:, :, None, None]
    bits = ((grouped >= least) * _BITS).sum(axis=(2, 3), dtype=np.uint32)
    # A space instead of the empty pattern, which some fonts draw as eight rings.
    return np.where(bits > 0, EMPTY + bits, SPACE).astype(np.uint32), inks


@dataclass(frozen=True, eq=False)
class Paper:
    """The characters of a picture as code points and their inks, both (rows, columns)."""

    codes: NDArray[np.uint32]
    inks: Inks

    @classmethod
    def blank(cls, columns: int, rows: int) -> "Paper":
        """Return a blank picture."""
        shape = rows, columns
        return cls(np.full(shape, SPACE, dtype=np.uint32), np.zeros(shape, dtype=np.uint8))

    def write(self, row: int, column: int, text: str, ink: int) -> None:
        """Write one-column characters; those beyond the right end are left out."""
        text = text[: max(self.codes.shape[1] - column, 0)]
        self.codes[row, column : column + len(text)] = [ord(one) for one in text]
        self.inks[row, column : column + len(text)] = ink


def ink_runs(codes: NDArray[np.uint32], inks: Inks) -> list[tuple[str, int]]:
    """Split a row of cells into strings of one ink each; spaces join the string before them."""
    # Joining spaces leaves a third of the strings; each costs 20 bytes of output and 20 µs.
    last = np.maximum.accumulate(np.where(codes != SPACE, np.arange(len(codes)), 0))
    inks = inks[last]
    text = codes.astype("<u4").tobytes().decode("utf-32-le")
    borders = [0, *(np.flatnonzero(np.diff(inks)) + 1).tolist(), len(text)]
    return [(text[first:end], int(inks[first])) for first, end in pairwise(borders) if end > first]
