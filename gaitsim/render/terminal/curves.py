"""Curves in braille dots, with axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.terminal.braille import (
    HIGH,
    SPACE,
    WIDE,
    Dots,
    Inks,
    cells,
    draw_lines,
    draw_points,
    empty,
)
from gaitsim.render.ticks import labels, ticks

AXIS, FIRST = 1, 2  # inks: of axes, and of the last series; the first has the highest
LEAST = 12, 4  # columns and rows that a plot takes at least
LINED = 8  # rows from which the axis below has a line
# Dots on and off along a line, by which series differ where there are no colours.
DASHES = ((1, 0), (5, 3), (2, 3), (9, 3), (1, 2), (6, 6))
SAMPLES = ("━━━", "╍╍╍", "┅┅┅", "━╸━", "┉┉┉", "━ ━")  # how a legend shows them
# A few scores far below the others, as of a first generation, would press all others flat.
OUTLIERS = 0.05
FINER = 4  # groups of points in the width of a dot
PRESSED = 4.0  # heights of the others, from which on such scores are left out


@dataclass(frozen=True, eq=False)
class Series:
    """One curve.

    Attributes:
        name: of it, in the legend.
        x: (points,), in ascending order.
        y: (points,); there are gaps where it is not finite.
    """

    name: str
    x: NDArray[Any]
    y: NDArray[Any]


@dataclass(frozen=True)
class Frame:
    """What the axes show: from where to where, and whether something lies below."""

    left: float
    right: float
    bottom: float
    top: float
    below: bool = False

    def dots(self, x: NDArray[Any], y: NDArray[Any] | None, picture: Dots) -> NDArray[np.float64]:
        """Where points are in a picture, (n, 2); without y spread over its height."""
        height, width = picture.shape
        across = (np.asarray(x, dtype=np.float64) - self.left) / (self.right - self.left)
        if y is None:
            down = np.linspace(0, 1, len(x))
        else:
            down = 1 - (np.asarray(y, dtype=np.float64) - self.bottom) / (self.top - self.bottom)
        return np.stack([across * (width - 1), down * (height - 1)], axis=1)


def frame_of(series: Sequence[Series]) -> Frame | None:
    """Axes that show all points, but for a few that lie far below; None where there are none."""
    drawn = [(one.x[at], one.y[at]) for one in series if (at := np.isfinite(one.y)).any()]
    if not drawn:
        return None
    y = np.concatenate([values for _, values in drawn])
    left = min(float(values[0]) for values, _ in drawn)
    right = max(float(values[-1]) for values, _ in drawn)
    low, top = float(y.min()), float(y.max())
    usual = float(np.quantile(y, OUTLIERS))
    below = top - low > (1 + PRESSED) * (top - usual) > 0
    bottom = usual if below else low
    if top - bottom <= 1e-9 * max(abs(top), abs(bottom)):
        # A constant: in the middle of axes that have some height.
        half = 0.1 * abs(top) or 1.0
        bottom, top = bottom - half, top + half
    return Frame(left, right if right > left else left + 1.0, bottom, top, below)


def plot(
    series: Sequence[Series],
    columns: int,
    rows: int,
    x_label: str = "",
    marks: Sequence[float] = (),
) -> tuple[NDArray[np.uint32], Inks]:
    """Curves, the first over the others, as code points and inks, both (rows, columns).

    Args:
        series: to draw.
        columns: of the picture.
        rows: of the picture, axes counted.
        x_label: what the axis below shows, of characters one column wide.
        marks: places on it where something begins, such as a stage.
    """
    codes = np.full((rows, columns), SPACE, dtype=np.uint32)
    inks = np.zeros((rows, columns), dtype=np.uint8)
    series = [thinned(one, WIDE * columns) for one in series]
    frame = frame_of(series)
    if frame is None or columns < LEAST[0] or rows < LEAST[1]:
        return codes, inks
    height = rows - (2 if rows >= LINED else 1)
    at = ticks(frame.bottom, frame.top, min(max(height // 2, 3), 6))
    words = labels(at)
    left = max(len(word) for word in words) + 2 if words else 1
    if columns - left < LEAST[0] // 2:
        return codes, inks
    dots = empty(columns - left, height)
    for mark in marks:
        draw_points(dots, frame.dots(np.full(height, mark), None, dots), AXIS)
    for index, one in enumerate(series):
        ink, dash = len(series) - 1 - index + FIRST, DASHES[index % len(DASHES)]
        _draw(dots, frame.dots(one.x, one.y, dots), ink, dash)
    codes[:height, left:], inks[:height, left:] = cells(dots, behind=AXIS)
    paper = _Paper(codes, inks)
    for row in range(height):
        paper.write(row, left - 1, "│")
    for value, word in zip(at, words, strict=True):
        row = int(frame.dots(np.array([frame.left]), np.array([value]), dots)[0, 1]) // HIGH
        paper.write(row, left - 2 - len(word) + 1, word + "┤")
    if frame.below:
        paper.write(height - 1, left - 1, "↓")
    _write_x(paper, frame, dots, left, x_label)
    return codes, inks


@dataclass(frozen=True, eq=False)
class _Paper:
    """Where text is written beside the curves."""

    codes: NDArray[np.uint32]
    inks: Inks

    def write(self, row: int, column: int, text: str) -> None:
        """Write one-column characters in the ink of the axes."""
        end = column + len(text)
        self.codes[row, column:end] = [ord(character) for character in text]
        self.inks[row, column:end] = AXIS


def _write_x(paper: _Paper, frame: Frame, dots: Dots, left: int, name: str) -> None:
    """The axis below: its line where there is a row for it, numbers, and what it shows."""
    rows, columns = paper.codes.shape
    lined = rows >= LINED
    if lined:
        paper.write(rows - 2, left - 1, "└" + "─" * (columns - left))
    end = columns - len(name) - 1 if name and columns - left > 3 * len(name) else columns
    if end < columns:
        paper.write(rows - 1, end + 1, name)
    at = ticks(frame.left, frame.right, max((columns - left) // 10, 2), whole=True)
    free = left - 1
    for value, word in zip(at, labels(at), strict=True):
        column = left + int(frame.dots(np.array([value]), None, dots)[0, 0]) // WIDE
        start = max(column - len(word) // 2, free)
        if start + len(word) <= end:
            if lined:
                paper.write(rows - 2, column, "┬")
            paper.write(rows - 1, start, word)
            free = start + len(word) + 1


def _draw(dots: Dots, points: NDArray[np.float64], ink: int, dash: tuple[int, int]) -> None:
    """A line through points (n, 2), with gaps where they are not finite."""
    whole = np.isfinite(points).all(axis=1)
    part = np.cumsum(~whole)[whole]  # points of the same part are joined
    points = points[whole]
    if not len(points):
        return
    joined = part[1:] == part[:-1]
    alone = ~(np.append(False, joined) | np.append(joined, False))
    draw_points(dots, points[alone], ink)
    lines = np.stack([points[:-1], points[1:]], axis=1)[joined]
    draw_lines(dots, lines, np.full(len(lines), ink), dash)


def thinned(series: Series, width: int) -> Series:
    """The same to the eye in so many dots: of many points in a row the lowest and the highest."""
    each = len(series.y) // max(FINER * width, 1)
    if each < 2:
        return series
    y = np.where(np.isfinite(series.y), series.y, np.nan)
    starts = np.arange(0, len(y), each)
    # fmin and fmax pass over gaps that are narrower than what is seen.
    y = np.stack([np.fmin.reduceat(y, starts), np.fmax.reduceat(y, starts)], axis=1)
    return Series(series.name, np.repeat(series.x[starts], 2), y.ravel())
