"""Jump mode: a letter on each focusable widget, which focuses it when typed.

The idea is from Posting and Amp.
"""

from typing import Any

from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.errors import NoWidget
from textual.geometry import Region
from textual.screen import ModalScreen, Screen
from textual.widget import Widget
from textual.widgets import Static

from gaitsim.tui.actions import bindings

LETTERS = "asdfghjklqwertyuiopzxcvbnm"


def targets(screen: Screen[Any]) -> dict[str, Widget]:
    """Return the visible, focusable widgets by letter, top left first."""
    window = screen.region
    found = [
        widget
        for widget in screen.focus_chain
        if _visible_region(widget).overlaps(window) and _visible_region(widget).area
    ]
    found.sort(key=lambda widget: (_visible_region(widget).y, _visible_region(widget).x))
    return dict(zip(LETTERS, found, strict=False))


def _visible_region(widget: Widget) -> Region:
    """Return the visible part of a widget."""
    try:
        place = widget.screen.find_widget(widget)
    except NoWidget:
        return Region()
    return place.region.intersection(place.clip)


class Jump(ModalScreen[Widget | None]):
    """Show letters on the widgets of a screen; return the chosen widget.

    Args:
        screen: screen below this one.
    """

    BINDINGS = bindings("jump")

    def __init__(self, screen: Screen[Any]) -> None:
        super().__init__()
        self._targets = targets(screen)

    def compose(self) -> ComposeResult:
        for letter, widget in self._targets.items():
            label = Static(Text(f" {letter} "), classes="jump-letter")
            seen = _visible_region(widget)
            label.styles.offset = (seen.x, seen.y)
            yield label
        yield Static("letter: focus the item under it · esc: cancel", id="jump-about")

    def on_key(self, event: events.Key) -> None:
        widget = self._targets.get(event.key)
        if widget is not None:
            event.stop()
            event.prevent_default()
            self.dismiss(widget)

    def on_resize(self) -> None:
        """Close, because the widgets have moved away from their letters."""
        if self.is_current and self.size != self.app.size:
            self.dismiss(None)
