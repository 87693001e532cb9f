"""The footfall diagram around a frame (Hildebrand 1965): a row a foot, a bar while it stands."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.terminal.body import SIDES
from gaitsim.render.terminal.braille import SPACE, Inks
from gaitsim.render.ticks import labels, ticks

QUIET, CURSOR, FIRST = 1, 2, 3  # inks: of swing, of the moment, and of the side of a bar
TIME = FIRST + SIDES
WINDOW = 4.0  # seconds shown, about: some strides of most bodies
WIDEST = 6  # halves of a cell that a frame takes at most, where there is room
SWING = "·"
_HALVES = " ▌▐█"  # on the ground in neither half of a cell, the first, the second, both
_STACKED = " ▀▄█"  # neither foot of a row, the upper, the lower, both
_NAME = 8  # characters of a foot's name, at most


def strip(
    touching: NDArray[np.bool_],
    names: Sequence[str],
    sides: NDArray[np.intp],
    frame: int,
    frame_rate: float,
    columns: int,
    rows: int,
) -> tuple[NDArray[np.uint32], Inks]:
    """The diagram: characters as code points, and their inks, both (rows, columns).

    It stands still where all of the motion has room, and else moves under the moment, which
    stays in the middle. Feet for which there are too few rows share a row, two in each. A row more
    than there are feet shows the time in seconds.

    Args:
        touching: (frames, feet).
        names: of the feet, as far as they have any; of characters one column wide.
        sides: of the feet, as `gaitsim.render.colours.sides` gives them.
        frame: the moment.
        frame_rate: Hz.
        columns: of the picture.
        rows: of the picture.
    """
    frames, feet = touching.shape
    codes = np.full((rows, columns), SPACE, dtype=np.uint32)
    inks = np.zeros((rows, columns), dtype=np.uint8)
    stacked = feet > rows
    longest = max((len(name) for name in names), default=0)
    gutter = min(2 * longest + 1 if stacked else longest, _NAME) + 1
    width = columns - gutter
    if width < 8 or not frames or not feet:
        return codes, inks
    steps = width if stacked else 2 * width
    each = max(1, round(WINDOW * frame_rate / steps))
    wider = min(max(steps // frames, 1), WIDEST)
    if wider > 1:  # a short motion
        touching, frame, frames, each = touching.repeat(wider, 0), frame * wider, frames * wider, 1
    rate = frame_rate * max(wider, 1) / each  # steps a second
    count = -(-frames // each)
    at = frame // each
    start = max(0, min(at - steps // 2, count - steps))
    start -= 0 if stacked else start % 2  # cell by cell: half as much to send
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
    area_inks[:] = np.where(marks == SPACE, QUIET, FIRST + sides[:lines, None])
    moment = (at - start) if stacked else (at - start) // 2
    if moment < wide:
        column = area[:, moment]
        column[:] = np.where(column == ord(SWING), ord("│"), column)
        area_inks[:, moment] = CURSOR
    for line in range(lines):
        own = names[2 * line : 2 * line + 2] if stacked else names[line : line + 1]
        name = " ".join(own) if len(" ".join(own)) < gutter else next(iter(own), "")
        name = name[: gutter - 1]
        codes[line, : len(name)] = [ord(character) for character in name]
        inks[line, : len(name)] = FIRST + sides[line]
    if rows > lines:
        _write_time(codes[lines], inks[lines], gutter, start / rate, rate / (1 if stacked else 2))
    return codes, inks


def _write_time(
    codes: NDArray[np.uint32], inks: Inks, gutter: int, first: float, rate: float
) -> None:
    """Write seconds below the diagram, whose columns are 1 / `rate` seconds each."""
    columns = len(codes)
    last = first + (columns - gutter) / rate
    at = ticks(first, last, max((columns - gutter) // 10, 2))
    words = [f"{label} s" for label in labels(at)]
    for value, word in zip(at, words, strict=True):
        start = gutter + round((value - first) * rate)
        if start + len(word) <= columns:
            codes[start : start + len(word)] = [ord(sign) for sign in word]
            inks[start : start + len(word)] = TIME


def _shares(touching: NDArray[np.bool_], each: int) -> NDArray[np.float64]:
    """How much of every `each` frames the feet are on the ground, (steps, feet)."""
    if each == 1:
        return touching.astype(np.float64)
    starts = np.arange(0, len(touching), each)
    sums = np.add.reduceat(touching.astype(np.float64), starts, axis=0)
    lengths = np.diff(np.append(starts, len(touching)))
    shares: NDArray[np.float64] = sums / lengths[:, None]
    return shares


def _pairs(shown: NDArray[np.bool_], signs: str) -> NDArray[np.uint32]:
    """A sign for each two rows of (n, m): (n / 2, m), the last row filled up."""
    if len(shown) % 2:
        shown = np.concatenate([shown, np.zeros_like(shown[:1])])
    which = shown[::2] + 2 * shown[1::2].astype(np.intp)
    return np.array([ord(sign) for sign in signs], dtype=np.uint32)[which]
