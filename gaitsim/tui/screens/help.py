"""The help of a screen, with all its keys, and jump mode, which focuses a widget by a letter."""

from typing import Any, NamedTuple

from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.errors import NoWidget
from textual.geometry import Region
from textual.screen import ModalScreen, Screen
from textual.widget import Widget
from textual.widgets import Markdown, Static

from gaitsim.tui.keys import PREFIX, bindings
from gaitsim.tui.screens.base import GaitScreen

LETTERS = "asdfghjklqwertyuiopzxcvbnm"  # of jump mode


class Help(ModalScreen[None]):
    """Show the help of a screen.

    Args:
        screen: screen to describe.
    """

    BINDINGS = bindings("help")

    def __init__(self, screen: Screen[Any]) -> None:
        super().__init__()
        self._text = screen.HELP_TEXT if isinstance(screen, GaitScreen) else ""
        self._keys = _keys(screen)

    def compose(self) -> ComposeResult:
        with VerticalScroll(classes="dialog", id="help") as scroll:
            scroll.border_title = "Help"
            scroll.border_subtitle = "esc: close"
            yield Static(self._keys, id="help-keys")
            yield Markdown(self._text.strip())

    def action_press(self, key: str) -> None:
        """Close the help and press a key on the screen below."""
        self.dismiss()
        self.call_after_refresh(self.app.simulate_key, key)


class _Row(NamedTuple):
    """An action: its displayed keys, the name of the first key, its meaning and its id."""

    shown: list[str]
    key: str
    about: str
    name: str


def _keys(screen: Screen[Any]) -> Table:
    """Return a table of actions: keys, meaning, and the id for the config file."""
    rows: dict[tuple[str, str], _Row] = {}
    for _, binding, enabled, tooltip in screen.active_bindings.values():
        if enabled and binding.description:
            key = screen.app.get_key_display(binding)
            about = _about(binding.description, tooltip or binding.tooltip)
            row = rows.setdefault(
                (binding.action, binding.description),
                _Row([], binding.key, about, binding.id or ""),
            )
            if key not in row.shown:
                row.shown.append(key)
    table = Table(box=None, padding=(0, 2, 0, 0), expand=True)
    table.add_column("key", style="bold", no_wrap=True)
    table.add_column("action", ratio=1)
    table.add_column("id for config.toml", style="dim", no_wrap=True)
    # The keys of the screen, then those of lists, then those of Textual, which have no ids.
    for row in sorted(rows.values(), key=lambda row: (not row.name, row.name.startswith(PREFIX))):
        style = Style(meta={"@click": f"screen.press({row.key!r})"})
        table.add_row(Text(" ".join(row.shown), style), Text(row.about, style), Text(row.name))
    return table


def _about(name: str, more: str) -> str:
    """Join the label of a key in the footer with its tooltip."""
    if more.casefold().startswith(name.casefold()):
        return more
    return f"{name}: {more[0].lower()}{more[1:]}" if more else name


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
    """Show letters on the widgets of a screen; return the chosen widget, as Posting and Amp do.

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
