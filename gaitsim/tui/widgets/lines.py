"""Lines of text that are redrawn only if they change."""

from collections.abc import Sequence
from typing import Any

from rich.text import Text
from textual.widgets import Static


class Lines(Static):
    """Lines clipped at the right edge; the widget is as high as their number by default."""

    DEFAULT_CSS = "Lines { width: 1fr; height: auto; }"

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._lines: list[Text] = []

    def show(self, lines: Sequence[Text]) -> None:
        """Replace the lines."""
        before, self._lines = self._lines, [*lines]
        if [(one, one.spans) for one in before] != [(one, one.spans) for one in lines]:
            higher = len(before) != len(lines)
            text = Text("\n", no_wrap=True, overflow="ellipsis", end="").join(lines)
            self.update(text, layout=higher)

    @property
    def text(self) -> str:
        """The plain text."""
        return "\n".join(line.plain for line in self._lines)
