"""The footfall diagram around a frame (Hildebrand 1965): a row per foot, with bars for stance."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.terminal.body import SIDES
from gaitsim.render.terminal.braille import SPACE, Inks, Paper
from gaitsim.render.ticks import labels, ticks

SWING_INK, CURSOR, FIRST = 1, 2, 3  # inks of swing, of the current frame, and of the first side
TIME = FIRST + SIDES
WINDOW = 4.0  # approximate seconds shown: a few strides of most bodies
MAX_FRAME_WIDTH = 6  # maximum width of a frame, in half cells
SWING = "·"
_HALVES = " ▌▐█"  # halves of a cell with ground contact: neither, first, second, both
_STACKED = " ▀▄█"  # feet of a shared row with ground contact: neither, upper, lower, both
_NAME = 8  # maximum characters of a foot's name


def strip(
    touching: NDArray[np.bool_],
    names: Sequence[str],
    sides: NDArray[np.intp],
    frame: int,
    frame_rate: float,
    columns: int,
    rows: int,
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw the diagram, as code points and their inks, both (rows, columns).

    If the whole motion fits, the diagram is static. Otherwise it scrolls and keeps the current
    frame in the middle. If there are fewer rows than feet, two feet share a row. If there are more
    rows than feet, the row below the feet shows the time in seconds.

    Args:
        touching: whether each foot touches the ground, (frames, feet).
        names: names of the feet that have one, in characters one column wide.
        sides: sides of the feet, as returned by `gaitsim.render.colours.sides`.
        frame: index of the current frame.
        frame_rate: frames per second, Hz.
        columns: width of the picture.
        rows: height of the picture.
    """
    frames, feet = touching.shape
    paper = Paper.blank(columns, rows)
    codes, inks = paper.codes, paper.inks
    stacked = feet > rows
    longest = max((len(name) for name in names), default=0)
    gutter = min(2 * longest + 1 if stacked else longest, _NAME) + 1
    width = columns - gutter
    if width < 8 or not frames or not feet:
        return codes, inks
    steps = width if stacked else 2 * width
    each = max(1, round(WINDOW * frame_rate / steps))
    wider = min(max(steps // frames, 1), MAX_FRAME_WIDTH)
    if wider > 1:  # a short motion
        touching, frame, frames, each = touching.repeat(wider, 0), frame * wider, frames * wider, 1
    rate = frame_rate * max(wider, 1) / each  # steps per second
    count = -(-frames // each)
    at = frame // each
    start = max(0, min(at - steps // 2, count - steps))
    start -= 0 if stacked else start % 2  # scrolling by whole cells sends half as much
    shown = _shares(touching, each)[start : start + steps] >= 0.5
    if stacked:
        shown = shown[:, : 2 * rows]
        marks = _pairs(shown.T, _STACKED)
        sides = sides[: 2 * rows : 2]
    else:
        marks = _pairs(shown, _HALVES).T
    lines, wide = marks.shape
    area = codes[:lines, gutter : gutter + wide]
    area[:] = np.where(marks == SPACE, ord(SWING), marks)
    area_inks = inks[:lines, gutter : gutter + wide]
    area_inks[:] = np.where(marks == SPACE, SWING_INK, FIRST + sides[:lines, None])
    moment = (at - start) if stacked else (at - start) // 2
    if moment < wide:
        column = area[:, moment]
        column[:] = np.where(column == ord(SWING), ord("│"), column)
        area_inks[:, moment] = CURSOR
    for line in range(lines):
        own = names[2 * line : 2 * line + 2] if stacked else names[line : line + 1]
        name = " ".join(own) if len(" ".join(own)) < gutter else next(iter(own), "")
        paper.write(line, 0, name[: gutter - 1], FIRST + sides[line])
    if rows > lines:
        _write_time(paper, lines, gutter, start / rate, rate / (1 if stacked else 2))
    return codes, inks


def _write_time(paper: Paper, row: int, gutter: int, first: float, rate: float) -> None:
    """Write seconds below the diagram, in which each column is 1 / `rate` seconds."""
    columns = paper.codes.shape[1]
    last = first + (columns - gutter) / rate
    at = ticks(first, last, max((columns - gutter) // 10, 2))
    words = [f"{label} s" for label in labels(at)]
    for value, word in zip(at, words, strict=True):
        start = gutter + round((value - first) * rate)
        if start + len(word) <= columns:
            paper.write(row, start, word, TIME)


def _shares(touching: NDArray[np.bool_], each: int) -> NDArray[np.float64]:
    """Return the share (steps, feet) of frames with ground contact in steps of `each` frames."""
    if each == 1:
        return touching.astype(np.float64)
    starts = np.arange(0, len(touching), each)
    sums = np.add.reduceat(touching.astype(np.float64), starts, axis=0)
    lengths = np.diff(np.append(starts, len(touching)))
    shares: NDArray[np.float64] = sums / lengths[:, None]
    return shares


def _pairs(shown: NDArray[np.bool_], signs: str) -> NDArray[np.uint32]:
    """Return a sign for each two rows of (n, m), as (n / 2, m), padding an odd last row."""
    if len(shown) % 2:
        shown = np.concatenate([shown, np.zeros_like(shown[:1])])
    which = shown[::2] + 2 * shown[1::2].astype(np.intp)
    return np.array([ord(sign) for sign in signs], dtype=np.uint32)[which]
