"""The base class of pictures drawn with characters; only changed rows are sent."""

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from gaitsim.render.terminal.braille import Inks, ink_runs

Picture = tuple[NDArray[np.uint32], Inks]


class Cells(Widget):
    """A widget that shows a grid of characters, each in an ink.

    A subclass provides the cells and the style of each ink, and calls `redraw` after changes.
    """

    ALLOW_SELECT = False  # else dragging a body would select text under the mouse

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._drawn: Picture | None = None
        self._strips: list[Strip] = []
        self._styles: list[Style] | None = None

    @abstractmethod
    def picture(self, columns: int, rows: int) -> Picture:
        """Return the characters as code points, and their inks, both (rows, columns)."""

    def placeholder(self) -> str:
        """Return the text shown instead of the picture; '' shows the picture."""
        return ""

    @abstractmethod
    def ink_styles(self) -> list[Style]:
        """Return the style of each ink; ink 0 is blank."""

    def ink_style(self, part: str = "", fog: float = 0.0) -> Style:
        """Return the style of a component class, on this widget's background.

        Args:
            part: component class; '' for the background alone.
            fog: share of the background in the colour, 0 to 1.
        """
        background = self.background_colors[1]
        ground = background.rich_color if background.a else None
        if not part:
            return Style(bgcolor=ground)
        colour = self.get_component_styles(part).color
        if colour.ansi is None and background.ansi is None:
            colour = (background + colour).blend(background, fog)
        return Style(color=colour.rich_color, bgcolor=ground)

    def forget_styles(self) -> None:
        """Discard the cached styles of the inks until the next drawing."""
        self._styles = None

    def redraw(self) -> None:
        """Draw the picture, and refresh the rows that changed."""
        columns, rows = self.content_size
        if not self.is_mounted or not columns or not rows:
            return
        placeholder = self.placeholder()
        if placeholder:
            self._drawn, self._strips = None, self._message_rows(placeholder, columns, rows)
            self.refresh()
            return
        codes, inks = self.picture(columns, rows)
        before, self._drawn = self._drawn, (codes, inks)
        if self._styles is None:
            self._styles = self.ink_styles()
            before = None
        if before is None or before[0].shape != codes.shape:
            self._strips = [self._strip(row) for row in range(rows)]
            self.refresh()
            return
        changed = ((before[0] != codes) | (before[1] != inks)).any(axis=1)
        at = np.flatnonzero(changed).tolist()
        for row in at:
            self._strips[row] = self._strip(row)
        if at:
            self.refresh(*(Region(0, row, columns, 1) for row in at))

    def render_line(self, y: int) -> Strip:
        """Return a row of the picture."""
        if self._drawn is not None and self._drawn[0].shape != self.content_size[::-1]:
            self.redraw()  # the resize event has not arrived yet
        if y < len(self._strips):
            return self._strips[y]
        return Strip.blank(self.content_size.width, self.rich_style)

    def notify_style_update(self) -> None:
        """Adopt the colours of the new theme."""
        super().notify_style_update()
        self.forget_styles()
        self.call_later(self.redraw)

    def on_resize(self) -> None:
        """Redraw at the new size."""
        self.redraw()

    def _message_rows(self, placeholder: str, columns: int, rows: int) -> list[Strip]:
        """Return the placeholder centred and wrapped, clipped to the size."""
        style = self.ink_style() + Style(color=self.rich_style.color)
        lines = Text(placeholder).wrap(self.app.console, max(columns - 2, 1))
        above = max((rows - len(lines)) // 2, 0)
        left = max((columns - max(line.cell_len for line in lines)) // 2, 0)
        strips = [Strip.blank(columns, style)] * above
        for line in lines:
            line.pad_left(left)
            strip = Strip(line.render(self.app.console, end=""))
            strips.append(strip.adjust_cell_length(columns).apply_style(style))
        return strips[:rows]

    def _strip(self, row: int) -> Strip:
        drawn, styles = self._drawn, self._styles
        assert drawn is not None, "set by redraw"
        assert styles is not None, "set by redraw"
        codes, inks = drawn[0][row], drawn[1][row]
        return Strip(
            [Segment(text, styles[ink]) for text, ink in ink_runs(codes, inks)], len(codes)
        )
