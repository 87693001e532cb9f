"""A scatter plot of a front in braille dots, with a cursor on a member."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.front_view import FrontView
from gaitsim.render.terminal.braille import HIGH, WIDE, Inks, Paper, cells, draw_points, empty
from gaitsim.render.terminal.member_picture import (
    AXIS,
    CURSOR,
    EMPTY,
    LEVELS,
    MARKED,
    NONE,
    ON_ANY,
    Codes,
    ColourScale,
    MemberPicture,
    PictureArea,
    Place,
    ink_of,
    inks_of,
    narrow,
    next_ahead,
)
from gaitsim.render.ticks import clipped, ends_of
from gaitsim.storage.files.history import FIGURE
from gaitsim.storage.snapshot import RunSnapshot

MANY = 400  # with more members, each is a single dot rather than a square of four
SINGLE = ink_of(LEVELS // 2 + 1, NONE)  # ink of members without a third objective
_MARGIN = 0.04  # empty share of an axis beyond the outermost points
_MEMBER, _CURSOR = "●", "◆"


class Scatter(MemberPicture):
    """Members of a front, and fainter ones of the last generation, along two objectives.

    Places are indices of members, (index,).

    Args:
        view: the front.
        names: names of the two axes.
        words: labels of the objectives with units, by name.
        columns: width of the picture.
        rows: height of the picture.
        colour: name of the objective that the colour shows; '' for none.
        others: whether to show the other individuals of the last generation.
        levels: levels of the colour, which depend on the background.
        shaded: whether to use characters instead of colours.

    Attributes:
        shown: whether each member has a finite value on both axes, (members,).
    """

    def __init__(
        self,
        view: FrontView,
        names: tuple[str, ...],
        words: Mapping[str, str],
        columns: int,
        rows: int,
        *,
        colour: str = "",
        others: bool = True,
        levels: range = ON_ANY,
        shaded: bool = False,
    ) -> None:
        self._view, self._names, self._shaded = view, names, shaded
        self._colour = "" if shaded else colour
        self._levels = levels
        self._values = np.stack([view.members.values[name] for name in names], axis=1)
        self.shown = np.asarray(np.isfinite(self._values).all(axis=1), np.bool_)
        behind = [view.others.get(name, np.empty(0)) for name in names] if others else []
        self._others = np.stack(behind, axis=1) if behind else np.empty((0, 2))
        self._others = self._others[np.isfinite(self._others).all(axis=1)]
        everything = np.concatenate([self._values[self.shown], self._others])
        # Never shaded: a braille character has as many dots in either case.
        self.area = PictureArea(
            columns, rows, np.array([ends_of(one, _MARGIN) for one in everything.T])
        )
        self._words = {name: narrow(word) for name, word in words.items()}
        self._dots = self._dots_of(self._values)

    def _dots_of(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the dots of values, (n, 2), from the upper left corner; NaN without a value."""
        low, high = self.area.ends[:, 0], self.area.ends[:, 1]
        size = np.array([WIDE * self._wide, HIGH * self._height]) - 1
        share = (clipped(values) - low) / (high - low)
        share[:, 1] = 1 - share[:, 1]
        dots: NDArray[np.float64] = np.round(share * size)
        return dots

    @property
    def _wide(self) -> int:
        return max(self.area.room[0], 1)

    @property
    def _height(self) -> int:
        return max(self.area.height, 1)

    def member(self, place: Place) -> int:
        return place[0] + 1

    def place_of(self, number: int) -> Place | None:
        """Return the place of a member, or that of the nearest number which is shown."""
        at = np.flatnonzero(self.shown)
        return (int(at[np.argmin(np.abs(at - (number - 1)))]),) if len(at) else None

    def place_near(self, *values: float) -> Place | None:
        return self._nearest(self._dots_of(np.array([values]))[0])

    def place_at(self, column: int, row: int) -> Place | None:
        across, down = column - self.area.left, row - 1
        if not (0 <= across < self._wide and 0 <= down < self._height):
            return None
        return self._nearest(np.array([WIDE * (across + 0.5), HIGH * (down + 0.5)]) - 0.5)

    def _nearest(self, dot: NDArray[np.float64]) -> Place | None:
        if not self.shown.any():
            return None
        return (int(np.nanargmin(((self._dots - dot) ** 2).sum(axis=1))),)

    def place_beside(self, place: Place, across: int, up: int) -> Place:
        at = np.flatnonzero(self.shown)
        away = (self._dots[at] - self._dots[place[0]]) * (1, -1)
        found = next_ahead(away, across, up)
        return place if found is None else (int(at[found]),)

    def values_at(self, place: Place) -> tuple[float, ...]:
        return tuple(self._values[place[0]].tolist())

    def draw(
        self, cursor: Place | None = None, marks: Mapping[Place, str] | None = None
    ) -> tuple[Codes, Inks]:
        area, paper, at = (
            self.area,
            Paper.blank(self.area.columns, self.area.rows),
            np.flatnonzero(self.shown),
        )
        if not area.fits:
            return paper.codes, paper.inks
        wide, height = self._wide, self._height
        dots, points = empty(wide, height), self._dots[at]
        draw_points(dots, self._dots_of(self._others), EMPTY)
        inks, scale = self._inks()
        if len(at) <= MANY:  # squares of four dots within a character
            points = np.concatenate([points // 2 * 2 + step for step in np.ndindex(2, 2)])
        draw_points(dots, points, np.resize(inks[at], len(points)))
        inside = slice(1, 1 + height), slice(area.left, area.left + wide)
        paper.codes[inside], paper.inks[inside] = cells(dots, behind=EMPTY)
        if self._shaded:
            for index in at.tolist():
                paper.write(*self._cell((index,)), _MEMBER, AXIS)
        for place, mark in (marks or {}).items():
            if self.shown[place]:
                paper.write(*self._cell(place), mark[:1], MARKED)
        up = self._label(1, area.columns - area.left, "↓↑")
        self.draw_axes(paper, wide, height, self._label(0, wide, "←→"), up)
        if cursor is not None:
            row, column = self._cell(cursor)
            self.draw_cursor(paper, row, column, height)
            if cursor not in (marks or {}):
                paper.write(row, column, _CURSOR, CURSOR)
        if scale is not None:
            arrow = "→" if self._view.directions[self._colour] == "max" else "←"
            title = f"{self._words[self._colour]}, better {arrow}"
            self.draw_scale(paper, area.rows - 1, title, scale, self._levels)
        else:
            self._draw_key(paper)
        return paper.codes, paper.inks

    def _draw_key(self, paper: Paper) -> None:
        """Explain the two kinds of points below the axes."""
        hidden = int((~self.shown).sum())
        text = f" front{f', {hidden:,} without values here' if hidden else ''}  "
        row = self.area.rows - 1
        paper.write(row, 0, _MEMBER, AXIS if self._shaded else SINGLE)
        paper.write(row, 1, text, AXIS)
        if len(self._others):
            paper.write(row, 1 + len(text), "⠿", EMPTY)
            paper.write(row, 3 + len(text), "last generation", AXIS)

    def _inks(self) -> tuple[NDArray[np.uint8], ColourScale | None]:
        """Return the ink of each member, and the colour scale if there is one."""
        count = len(self.shown)
        if not self._colour:
            return np.full(count, AXIS if self._shaded else SINGLE, np.uint8), None
        values = self._view.members.values[self._colour]
        scale = ColourScale.of(values)
        return inks_of(values, scale, self._levels), scale

    def _cell(self, place: Place) -> tuple[int, int]:
        """Return the row and the column of a member."""
        across, down = self._dots[place[0]].astype(int)
        return 1 + int(down) // HIGH, self.area.left + int(across) // WIDE

    def _label(self, at: int, room: int, arrows: str) -> str:
        """Return the label of an axis with an arrow to better values, less or more."""
        name = self._names[at]
        more = self._view.directions[name] == "max"
        return f"{_cut(self._words[name], room - 9)}, better {arrows[more]}"


def _cut(text: str, room: int) -> str:
    return text if len(text) <= room else text[: max(room - 1, 1)] + "…"


def summary(run: RunSnapshot, view: FrontView) -> str:
    """Return generation, members and, if the search records it, the hypervolume."""
    volume, count = run.history.get(f"{FIGURE}hypervolume"), len(view.members.scores)
    parts = [f"generation {run.generation:,}", f"{count:,} member{'s' * (count != 1)}"]
    if volume is not None:
        parts.append(f"hypervolume {volume[-1]:.4g}".replace("-", "−"))
    return "  ".join(parts)
