"""The help of a screen, with all its keys."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.dom import DOMNode
from textual.screen import Screen
from textual.widgets import Markdown, OptionList

from gaitsim.tui.keys import PREFIX, bindings
from gaitsim.tui.screens.base import Dialog, GaitScreen, unavailable


class Help(Dialog[None]):
    """Show the help of a screen; Enter or a click on an action runs it.

    Args:
        screen: screen to describe.
    """

    BINDINGS = bindings("help")

    def __init__(self, screen: Screen[Any]) -> None:
        super().__init__()
        self._text = screen.HELP_TEXT if isinstance(screen, GaitScreen) else ""
        self._rows = _rows(screen)

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog", id="help") as box:
            box.border_title = "Help"
            box.border_subtitle = "enter: run the action · tab: text · esc: close"
            yield OptionList(*_prompts(self._rows), id="help-keys")
            if self._text:
                with VerticalScroll(id="help-text"):
                    yield Markdown(self._text.strip())

    @on(OptionList.OptionSelected)
    def _run(self, event: OptionList.OptionSelected) -> None:
        """Close the help and run an action, or report why it is unavailable."""
        row = self._rows[event.option_index]
        if row.reason:
            self.notify(row.reason, title=row.about, markup=False)
            return
        self.dismiss()
        run = partial(self.app.run_action, row.action, default_namespace=row.node)
        self.call_after_refresh(run)


class _Row(NamedTuple):
    """An action: its displayed keys, meaning and id, and what runs it or why nothing does."""

    keys: list[str]
    about: str
    name: str
    action: str
    node: DOMNode
    reason: str = ""


def _rows(screen: Screen[Any]) -> list[_Row]:
    """Return the actions of a screen: its own, those of lists, then Textual's without ids."""
    rows: dict[tuple[str, str], _Row] = {}
    for node, binding, enabled, tooltip in screen.active_bindings.values():
        if enabled and binding.description:
            key = screen.app.get_key_display(binding)
            about = _about(binding.description, tooltip or binding.tooltip)
            row = rows.setdefault(
                (binding.action, binding.description),
                _Row([], about, binding.id or "", binding.action, node),
            )
            if key not in row.keys:
                row.keys.append(key)
    found = [*rows.values()]
    if isinstance(screen, GaitScreen):
        for binding, reason in unavailable(screen, {title for _, title in rows}):
            keys = [screen.app.get_key_display(one) for one in Binding.make_bindings([binding])]
            about = _about(binding.description, binding.tooltip)
            found.append(_Row(keys[:1], about, binding.id or "", "", screen, reason))
    return sorted(found, key=lambda row: (not row.name, row.name.startswith(PREFIX)))


def _prompts(rows: Sequence[_Row]) -> Iterator[Table]:
    """Yield a line for each action: keys, meaning, and the id for the config file."""
    width = max((cell_len(" ".join(row.keys)) for row in rows), default=0)
    for row in rows:
        line = Table.grid(padding=(0, 2, 0, 0), expand=True)
        line.add_column(style="dim" if row.reason else "bold", no_wrap=True, width=width)
        line.add_column(style="dim" if row.reason else "", ratio=1)
        line.add_column(style="dim", no_wrap=True)
        line.add_row(Text(" ".join(row.keys)), Text(row.about), Text(row.name))
        yield line


def _about(name: str, more: str) -> str:
    """Join the label of a key in the footer with its tooltip."""
    if more.casefold().startswith(name.casefold()):
        return more
    return f"{name}: {more[0].lower()}{more[1:]}" if more else name
