"""Curves in braille dots, with axes; sparklines, curves in one line of text."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.series import Series
from gaitsim.render.terminal.braille import (
    EMPTY,
    HIGH,
    WIDE,
    Dots,
    Inks,
    Paper,
    cells,
    draw_lines,
    draw_points,
    empty,
)
from gaitsim.render.ticks import MAX_VALUE, clipped, labels, ticks

_LEFT, _RIGHT = (0x40, 0x04, 0x02, 0x01), (0x80, 0x20, 0x10, 0x08)  # bits of dots, lowest first
# The bits of the dots from one height to another, by the side of a character.
_SPANS = np.array(
    [
        [[sum(bits[low : high + 1]) for high in range(HIGH)] for low in range(HIGH)]
        for bits in (_LEFT, _RIGHT)
    ]
)


def sparkline(
    values: Sequence[float] | NDArray[np.float64],
    width: int,
    scale: tuple[float, float] | None = None,
) -> str:
    """Return a curve as a line of dots in at most `width` characters, each two dots wide.

    The line has gaps where a value is not finite. A dot that covers several values shows the last
    of them, so that the newest value is always visible. A flat curve is drawn at the bottom.

    Args:
        values: values of the curve.
        width: maximum number of characters.
        scale: values drawn lowest and highest; None uses the range of the curve.
    """
    curve = np.asarray(values, dtype=np.float64)
    if width <= 0 or not len(curve):
        return ""
    if len(curve) > (most := WIDE * width):
        curve = curve[np.linspace(len(curve) / most - 1, len(curve) - 1, most).astype(int)]
    finite = np.isfinite(curve)
    if not finite.any():
        return " " * -(-len(curve) // WIDE)
    low, high = scale or (curve[finite].min(), curve[finite].max())
    # Halving keeps the difference of any two finite values finite.
    heights, top = np.where(finite, curve, low).clip(low, high) / 2 - low / 2, high / 2 - low / 2
    at = np.rint(heights / top * (HIGH - 1) if top > 0 else 0 * heights).astype(int)
    before = np.append(at[:1], np.where(finite[:-1], at[:-1], at[1:]))
    bits = np.zeros(len(at) + len(at) % WIDE, dtype=int)
    spans = np.where(before < at, before + 1, at), np.where(before > at, before - 1, at)
    bits[: len(at)] = np.where(finite, _SPANS[np.arange(len(at)) % WIDE, *spans], 0)
    pairs = bits.reshape(-1, WIDE).sum(axis=1).tolist()
    return "".join(chr(EMPTY + dots) if dots else " " for dots in pairs)


AXIS, CURSOR, FIRST = 1, 2, 3  # inks of axes, cursor and last series; the first series is highest
MAX_INKS = 250
MIN_SIZE = 12, 4  # minimum columns and rows of a plot
MIN_LINED_ROWS = 8  # minimum rows of a plot whose horizontal axis has a line
# Dots on and off along a line, which distinguish series without colours.
DASHES = ((1, 0), (5, 3), (2, 3), (9, 3), (1, 2), (6, 6))
MARKERS = "●◆▲■▼◇○"  # on the lines, as more than a few dashes are hard to distinguish
_PIECES = ("━", "╍", "┅", "━", "┉", "╺")  # samples of the dashes for legends
MARKER_DISTANCE = 16  # approximate columns between two markers of a line
GROUPS_PER_DOT = 4  # groups of points per dot, horizontally
# A few very low scores, for example in the first generations, would flatten the rest of the
# curves.
MAX_OUTLIERS = 0.05  # maximum share of points left out below the axis
MIN_OUTLIER_DISTANCE = (
    4.0  # minimum distance of such points below the others, in heights of the others
)


@dataclass(frozen=True)
class Scale:
    """One axis, given by its ends."""

    low: float
    high: float

    def share(self, values: NDArray[Any] | float) -> NDArray[np.float64]:
        """Return the position of values along the axis, from 0 at the low end to 1 at the high."""
        found = clipped(np.asarray(values, dtype=np.float64))
        return (found - self.low) / (self.high - self.low)

    def value(self, share: float) -> float:
        """Return the value at a share of the axis."""
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Frame:
    """The axes of a plot, and whether points lie below the vertical axis."""

    x: Scale
    y: Scale
    below: bool = False

    def dots(self, x: NDArray[Any], y: NDArray[Any] | None, picture: Dots) -> NDArray[np.float64]:
        """Return the dots (n, 2) of points; without y they are spread over the full height."""
        height, width = picture.shape
        down = np.linspace(0, 1, len(x)) if y is None else 1 - self.y.share(y)
        return np.stack([self.x.share(x) * (width - 1), down * (height - 1)], axis=1)


def frame_of(series: Sequence[Series], *, whole: bool = False) -> Frame | None:
    """Return the axes of curves; None if they have no finite point.

    The vertical axis covers all points except, unless `whole`, a few points far below the others.
    """
    found = [(one, at) for one in series if (at := np.isfinite(one.y)).any()]
    if not found:
        return None
    drawn = [one.y[at] for one, at in found if not one.incomparable]
    y = np.clip(np.concatenate(drawn or [one.y[at] for one, at in found]), -MAX_VALUE, MAX_VALUE)
    left = min(float(one.x[at][0]) for one, at in found)
    right = max(float(one.x[at][-1]) for one, at in found)
    low, top = float(y.min()), float(y.max())
    usual = float(np.quantile(y, MAX_OUTLIERS))
    cut = not whole and top - low > (1 + MIN_OUTLIER_DISTANCE) * (top - usual) > 0
    low = usual if cut else low
    if top - low <= max(1e-9 * max(abs(top), abs(low)), 1e-300):
        # Centre a constant curve on an axis of some height.
        half = 0.1 * abs(top) or 1.0
        low, top = low - half, top + half
    return Frame(Scale(left, right if right > left else left + 1.0), Scale(low, top), bool(cut))


@dataclass(frozen=True)
class Area:
    """The area of the curves in a picture: first column, size in cells, axes and their numbers."""

    left: int
    columns: int
    rows: int
    frame: Frame
    numbers: tuple[tuple[float, str], ...]

    def share(self, column: float) -> float:
        """Return the position of a column along the horizontal axis, 0 to 1."""
        return min(max((column - self.left + 0.5) / max(self.columns, 1), 0.0), 1.0)


def sample(index: int) -> str:
    """Return a sample of a curve's line and marker, for legends."""
    piece = _PIECES[index % len(_PIECES)]
    return piece + MARKERS[index % len(MARKERS)] + piece


def ink_of(index: int, count: int) -> int:
    """Return the ink of series `index` of `count`."""
    return FIRST + (count - 1 - index) % MAX_INKS


def area_of(
    series: Sequence[Series], columns: int, rows: int, *, whole: bool = False
) -> Area | None:
    """Return the area of curves; None if there are no points or not enough space."""
    frame = frame_of(series, whole=whole)
    if frame is None or columns < MIN_SIZE[0] or rows < MIN_SIZE[1]:
        return None
    height = rows - (2 if rows >= MIN_LINED_ROWS else 1)
    numbers = ticks(frame.y.low, frame.y.high, min(max(height // 2, 3), 6))
    words = labels(numbers)
    left = max(map(len, words), default=-1) + 2
    if columns - left < MIN_SIZE[0] // 2:
        return None
    return Area(left, columns - left, height, frame, tuple(zip(numbers, words, strict=True)))


def plot(
    series: Sequence[Series],
    columns: int,
    rows: int,
    x_label: str = "",
    marks: Sequence[float] = (),
    cursor: float | None = None,
    *,
    whole: bool = False,
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw curves, the first on top, as code points and inks, both (rows, columns).

    Args:
        series: curves to draw.
        columns: width of the picture.
        rows: height of the picture, including the axes.
        x_label: label of the horizontal axis, in characters one column wide.
        marks: values on the horizontal axis with a vertical line, such as the start of a stage.
        cursor: value on the horizontal axis at which the cursor is; None for no cursor.
        whole: whether the vertical axis includes the few points far below the others.
    """
    paper = Paper.blank(columns, rows)
    codes, inks = paper.codes, paper.inks
    area = area_of(series, columns, rows, whole=whole)
    if area is None:
        return codes, inks
    series = [thin_series(one, WIDE * columns) for one in series]
    frame, left, height = area.frame, area.left, area.rows
    dots = empty(area.columns, height)
    for mark in marks:
        draw_points(dots, frame.dots(np.full(height, mark), None, dots), AXIS)
    if cursor is not None:
        draw_points(dots, frame.dots(np.full(HIGH * height, cursor), None, dots), CURSOR)
    for index, one in enumerate(series):
        ink, dash = ink_of(index, len(series)), DASHES[index % len(DASHES)]
        if one.incomparable:
            ink, dash = AXIS, DASHES[0]
        _draw(dots, _points(one, frame, dots), one.stages, ink, dash)
    codes[:height, left:], inks[:height, left:] = cells(dots, behind=CURSOR)
    if len(series) > 1:
        for index, one in enumerate(series):
            if one.incomparable:
                continue
            _mark(codes[:height, left:], inks[:height, left:], one, frame, index, len(series))
    for row in range(height):
        paper.write(row, left - 1, "│", AXIS)
    for value, word in area.numbers:
        row = int(frame.dots(np.array([frame.x.low]), np.array([value]), dots)[0, 1]) // HIGH
        paper.write(row, left - 2 - len(word) + 1, word + "┤", AXIS)
    if frame.below:
        paper.write(height - 1, left - 1, "↓", AXIS)
    _write_x(paper, frame, dots, left, x_label)
    return codes, inks


def _points(series: Series, frame: Frame, dots: Dots) -> NDArray[np.float64]:
    """Return the dots (n, 2) of the points of a series."""
    if not series.incomparable:
        return frame.dots(series.x, series.y, dots)
    found = []
    for part in np.split(np.arange(len(series.x)), series.stages):
        stage = Series(series.name, series.x[part], series.y[part])
        own = frame_of([stage]) or frame
        found.append(replace(frame, y=own.y).dots(stage.x, stage.y, dots))
    return np.concatenate(found)


def _mark(
    codes: NDArray[np.uint32], inks: Inks, series: Series, frame: Frame, index: int, count: int
) -> None:
    """Write the markers of a series, away from markers of other series if there is space."""
    rows, columns = codes.shape
    at = np.isfinite(series.y)
    x, y = frame.x.share(series.x[at]), frame.y.share(series.y[at])
    inside = (y >= 0) & (y <= 1)
    x, y = x[inside], y[inside]
    if not len(x):
        return
    number = max(columns // max(MARKER_DISTANCE, 2 * count), 1)
    wanted = (np.arange(number) + (index + 1) / (count + 1)) / number
    for place in {int(np.abs(x - one).argmin()) for one in wanted}:
        row = round((1 - y[place]) * (HIGH * rows - 1)) // HIGH
        column = round(x[place] * (WIDE * columns - 1)) // WIDE
        codes[row, column] = ord(MARKERS[index % len(MARKERS)])
        inks[row, column] = ink_of(index, count)


def _write_x(paper: Paper, frame: Frame, dots: Dots, left: int, name: str) -> None:
    """Write the horizontal axis: a line if there is a row for it, numbers and the label."""
    rows, columns = paper.codes.shape
    lined = rows >= MIN_LINED_ROWS
    if lined:
        paper.write(rows - 2, left - 1, "└" + "─" * (columns - left), AXIS)
    end = columns - len(name) - 1 if name and columns - left > 3 * len(name) else columns
    if end < columns:
        paper.write(rows - 1, end + 1, name, AXIS)
    at = ticks(frame.x.low, frame.x.high, max((columns - left) // 10, 2), whole=True)
    free = left - 1
    for value, word in zip(at, labels(at), strict=True):
        column = left + int(frame.dots(np.array([value]), None, dots)[0, 0]) // WIDE
        start = max(column - len(word) // 2, free)
        if start + len(word) <= end:
            if lined:
                paper.write(rows - 2, column, "┬", AXIS)
            paper.write(rows - 1, start, word, AXIS)
            free = start + len(word) + 1


def _draw(
    dots: Dots, points: NDArray[np.float64], stages: Sequence[int], ink: int, dash: tuple[int, int]
) -> None:
    """Draw a line through points (n, 2), broken where a point is not finite or a stage begins."""
    whole = np.isfinite(points).all(axis=1)
    gaps = ~whole + np.bincount(np.array(stages, dtype=np.intp), minlength=len(points))
    part, points = np.cumsum(gaps)[whole], points[whole]  # a line joins the points of each part
    if not len(points):
        return
    joined = part[1:] == part[:-1]
    alone = ~(np.append(False, joined) | np.append(joined, False))
    draw_points(dots, points[alone], ink)
    lines = np.stack([points[:-1], points[1:]], axis=1)[joined]
    draw_lines(dots, lines, np.full(len(lines), ink), dash)


def thin_series(series: Series, width: int) -> Series:
    """Return a series with fewer points that looks the same in a picture `width` dots wide.

    Each group of neighbouring points is replaced by its lowest and its highest value.
    """
    each = len(series.y) // max(GROUPS_PER_DOT * width, 1)
    if each < 2:
        return series
    y = np.where(np.isfinite(series.y), series.y, np.nan)
    # No group extends over the border of a stage, where the line is broken.
    bounds = [0, *series.stages, len(y)]
    parts = [np.arange(a, b, each) for a, b in pairwise(bounds)]
    starts = np.concatenate(parts)
    # fmin and fmax ignore gaps too narrow to be visible.
    y = np.stack([np.fmin.reduceat(y, starts), np.fmax.reduceat(y, starts)], axis=1)
    stages = tuple(2 * np.cumsum([len(part) for part in parts])[:-1].tolist())
    return replace(series, x=np.repeat(series.x[starts], 2), y=y.ravel(), stages=stages)
