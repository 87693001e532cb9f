"""Jump mode: letters on all focusable widgets; typing one focuses its widget.

The idea is from Posting and Amp.
"""

from typing import Any, ClassVar

from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.errors import NoWidget
from textual.geometry import Region
from textual.screen import ModalScreen, Screen
from textual.widget import Widget
from textual.widgets import Static

LETTERS = "asdfghjklqwertyuiopzxcvbnm"


def targets(screen: Screen[Any]) -> dict[str, Widget]:
    """Return the visible, focusable widgets by letter, top left first."""
    window = screen.region
    found = [
        widget
        for widget in screen.focus_chain
        if _seen(widget).overlaps(window) and _seen(widget).area
    ]
    found.sort(key=lambda widget: (_seen(widget).y, _seen(widget).x))
    return dict(zip(LETTERS, found, strict=False))


def _seen(widget: Widget) -> Region:
    """Return the visible part of a widget."""
    try:
        place = widget.screen.find_widget(widget)
    except NoWidget:
        return Region()
    return place.region.intersection(place.clip)


class Jump(ModalScreen[Widget | None]):
    """Show the letters; return the chosen widget.

    Args:
        of: screen below.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Stay", id="jump.stay", tooltip="Keep the focus"),
    ]

    def __init__(self, of: Screen[Any]) -> None:
        super().__init__()
        self._targets = targets(of)

    def compose(self) -> ComposeResult:
        for letter, widget in self._targets.items():
            label = Static(Text(f" {letter} "), classes="jump-letter")
            seen = _seen(widget)
            label.styles.offset = (seen.x, seen.y)
            yield label
        yield Static("Press a letter to go there, esc to stay", id="jump-about")

    def on_key(self, event: events.Key) -> None:
        widget = self._targets.get(event.key)
        if widget is not None:
            event.stop()
            event.prevent_default()
            self.dismiss(widget)

    def on_resize(self) -> None:
        """Close, as the letters would be at their old places."""
        if self.is_current and self.size != self.app.size:
            self.dismiss(None)
