"""Lines of text that are redrawn only if they change."""

from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

from rich.style import Style
from rich.text import Text
from textual.geometry import Region, Size
from textual.strip import Strip
from textual.widget import Widget


class Lines(Widget):
    """Lines clipped at the right edge; the widget is as high as their number by default."""

    DEFAULT_CSS = "Lines { width: 1fr; height: auto; }"

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._lines: list[Text] = []
        self._strips: dict[int, Strip] = {}

    def show(self, lines: Sequence[Text]) -> None:
        """Replace the lines."""
        before, self._lines = self._lines, list(lines)
        height = self.styles.height
        if len(before) != len(lines) and (height is None or height.is_auto):
            self._strips.clear()
            self.refresh(layout=True)
            return
        changed = [
            row
            for row, (old, new) in enumerate(zip_longest(before, lines))
            if old is None or new is None or old != new or old.spans != new.spans
        ]
        for row in changed:
            self._strips.pop(row, None)
        if changed:
            self.refresh(*(Region(0, row, self.size.width, 1) for row in changed))

    @property
    def text(self) -> str:
        """The plain text."""
        return "\n".join(line.plain for line in self._lines)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return len(self._lines)

    def on_resize(self) -> None:
        self._strips.clear()

    def notify_style_update(self) -> None:
        super().notify_style_update()
        self._strips.clear()

    def render_line(self, y: int) -> Strip:
        if y not in self._strips:
            width, style = self.size.width, self.rich_style
            ground = Style(bgcolor=style.bgcolor, color=style.color)
            segments = (
                self._lines[y].render(self.app.console, end="") if y < len(self._lines) else ()
            )
            strip = Strip(segments).apply_style(ground)
            self._strips[y] = strip.adjust_cell_length(width, ground)
        return self._strips[y]
