"""The help of a screen: its purpose, and all available keys, which can also be clicked."""

from typing import Any, NamedTuple

from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import ModalScreen, Screen
from textual.widgets import Markdown, Static

from gaitsim.tui.actions import bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.vi import PREFIX


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
