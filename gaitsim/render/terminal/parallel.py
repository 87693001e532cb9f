"""Parallel coordinates in braille lines, with a selected axis and a selected item."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.parallel_view import ParallelView
from gaitsim.render.terminal.braille import HIGH, WIDE, Inks, cells, draw_lines, draw_points, empty
from gaitsim.render.terminal.member_picture import (
    CURSOR,
    EMPTY,
    NONE,
    ON_ANY,
    POINTED,
    Codes,
    ColourScale,
    Paper,
    ink_of,
    inks_of,
    narrow,
)

MOST = 1_000  # maximum number of lines, those with the highest scores; more would be slow
MIN_ROWS = 8
_MIN_SPACE = 6  # minimum columns between two axes
SELECTED = ink_of(POINTED, NONE)


class ParallelPicture:
    """A line for each item across vertical axes; the colour of a line is its score.

    Args:
        view: the items.
        order: indices of the axes, from left to right.
        flipped: indices of axes whose low end is at the top.
        columns: width of the picture.
        rows: height of the picture.
        levels: levels of the colours, which depend on the background.
        shaded: whether all lines but the selected one are faint, for terminals without colours.
    """

    def __init__(
        self,
        view: ParallelView,
        order: Sequence[int],
        flipped: frozenset[int],
        columns: int,
        rows: int,
        *,
        levels: range = ON_ANY,
        shaded: bool = False,
    ) -> None:
        self._view, self._order, self._flipped = view, order, flipped
        self._columns, self._rows = columns, rows
        self._levels, self._shaded = levels, shaded
        self._height = rows - 2  # below the names and the high ends
        shares = np.array(view.shares)
        at = [*flipped]
        shares[:, at] = 1 - shares[:, at]
        self.heights = shares[:, order]
        self._dots = None if not self.fits else self._base()

    @property
    def fits(self) -> bool:
        """Whether the picture has enough space."""
        return self._rows >= MIN_ROWS and self._columns >= _MIN_SPACE * len(self._order)

    @property
    def space(self) -> int:
        """The columns between two axes."""
        return self._columns // len(self._order)

    def column(self, place: int) -> int:
        """Return the column of the axis at a place."""
        return place * self.space

    def _points(self, items: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the dots of items on each axis, (items, axes, 2)."""
        high = HIGH * self._height - 1
        down = np.round((1 - self.heights[items]) * high)
        across = np.array([WIDE * self.column(place) for place in range(len(self._order))], float)
        return np.stack([np.broadcast_to(across, down.shape), down], axis=-1)

    def _base(self) -> NDArray[np.uint8]:
        """Return the dots of all axes and lines."""
        scores = self._view.scores
        dots = empty(self._columns, self._height)
        high = np.arange(HIGH * self._height)
        for place in range(len(self._order)):
            column = np.full(len(high), WIDE * self.column(place))
            draw_points(dots, np.stack([column, high], axis=1), EMPTY)
        known = np.where(np.isfinite(scores), scores, -np.inf)
        items = np.argsort(-known, kind="stable")[:MOST]
        inks = inks_of(scores, ColourScale.of(scores), self._levels)
        inks = np.full_like(inks, EMPTY) if self._shaded else inks
        self._draw(dots, items, inks[items])
        return dots

    def _draw(self, dots: NDArray[np.uint8], items: NDArray[np.intp], inks: Inks) -> None:
        points = self._points(items)
        ends = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)
        draw_lines(dots, ends, np.repeat(inks, points.shape[1] - 1))

    def draw(self, axis: int, item: int | None) -> tuple[Codes, Inks]:
        """Draw everything, as code points and inks, both (rows, columns).

        Args:
            axis: place of the selected axis.
            item: selected item; None for none.
        """
        shape = self._rows, self._columns
        paper = Paper(np.full(shape, ord(" "), np.uint32), np.zeros(shape, np.uint8))
        if self._dots is None:
            return paper.codes, paper.inks
        dots = self._dots.copy()
        if item is not None:
            self._draw(dots, np.array([item]), np.array([SELECTED], np.uint8))
        inside = slice(1, 1 + self._height)
        paper.codes[inside], paper.inks[inside] = cells(dots, behind=EMPTY)
        for place, index in enumerate(self._order):
            one, column = self._view.axes[index], self.column(place)
            flipped = index in self._flipped
            arrow = {"max": "↓" if flipped else "↑", "min": "↑" if flipped else "↓", "": ""}
            name = narrow(one.label)
            room = self.space - 1 - len(arrow[one.better])
            if len(name) > room:  # the end of a name tells options apart
                name = "…" + name[len(name) - room + 1 :]
            ink = CURSOR if place == axis else 1
            paper.write(0, column, name + arrow[one.better], ink)
            for share, word in one.ticks(max(self._height // 4, 2)):
                row = 1 + round((share if flipped else 1 - share) * (self._height - 1))
                if place == axis or one.choices or min(share, 1 - share) < 0.2:
                    paper.write(row, column + 1, narrow(word)[: self.space - 2])
        return paper.codes, paper.inks

    def beside(self, axis: int, item: int | None, up: int) -> int | None:
        """Return the item that is next above or below another on an axis."""
        heights = self.heights[:, axis]
        order = np.lexsort((np.arange(len(heights)), heights))
        order = order[np.isfinite(heights[order])]
        at = np.flatnonzero(order == item)
        if not len(at):
            return int(order[-1]) if len(order) else None
        return int(order[min(max(int(at[0]) + up, 0), len(order) - 1)])

    def nearest(self, column: int, row: int) -> tuple[int, int | None]:
        """Return the place of the nearest axis, and the item whose line is nearest there."""
        last = len(self._order) - 1
        place = min(max(round(column / self.space), 0), last)
        across = min(max(column / self.space, 0.0), float(last))
        left = min(int(across), last - 1) if last else 0
        share = across - left
        right = min(left + 1, last)
        heights = (1 - share) * self.heights[:, left] + share * self.heights[:, right]
        away = np.abs(heights - (1 - (row - 1) / max(self._height - 1, 1)))
        return place, int(np.nanargmin(away)) if np.isfinite(away).any() else None
