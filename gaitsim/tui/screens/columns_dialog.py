"""A dialog to choose the columns of the list of runs."""

from collections.abc import Sequence
from typing import ClassVar

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.widgets import Input, Static

from gaitsim.errors import nearest
from gaitsim.render.terminal.text import visible
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog
from gaitsim.tui.screens.questions import WordSuggester
from gaitsim.tui.widgets.lists import ChoiceList

ON, OFF = "◆ ", "◇ "


class ColumnsDialog(Dialog[tuple[str, ...] | None]):
    """Choose columns and their order; return their keys, () for the usual ones, or None.

    Args:
        chosen: keys of the current columns.
        offered: keys offered in the list.
        others: keys that can be typed: options and terms of the runs.
    """

    BINDINGS: ClassVar[list[BindingType]] = bindings("columns")

    def __init__(
        self, chosen: Sequence[str], offered: Sequence[str], others: Sequence[str]
    ) -> None:
        super().__init__()
        self.chosen = [*chosen]
        self._offered, self._others = offered, others

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = (
                "enter: toggle · < >: move · u: usual · ctrl+s: apply · esc: cancel"
            )
            yield Static("Columns", classes="dialog-title")
            yield ChoiceList(id="items")
            yield Input(
                placeholder="an option or a term, such as evolution.population",
                suggester=WordSuggester(self._others),
                id="other",
            )
            yield Static(id="ask-problem", classes="problem")

    def on_mount(self) -> None:
        self._list(self.chosen[0] if self.chosen else "")
        self.query_one(ChoiceList).focus()

    @property
    def _keys(self) -> list[str]:
        return [*self.chosen, *(key for key in self._offered if key not in self.chosen)]

    def _list(self, at: str) -> None:
        items = self.query_one(ChoiceList)
        items.clear_options()
        items.add_options(
            Text((ON if key in self.chosen else OFF) + visible(key)) for key in self._keys
        )
        if at in self._keys:
            items.highlighted = self._keys.index(at)

    @property
    def _highlighted(self) -> str:
        at = self.query_one(ChoiceList).highlighted
        return "" if at is None else self._keys[at]

    @on(ChoiceList.OptionSelected)
    def _toggle(self) -> None:
        """Show or hide the highlighted column."""
        key, at = self._highlighted, self.query_one(ChoiceList).highlighted
        if key in self.chosen:
            self.chosen.remove(key)
        elif key:
            self.chosen.append(key)
        self._list("")
        self.query_one(ChoiceList).highlighted = at

    def action_move(self, step: int) -> None:
        """Move the highlighted column to the left or right."""
        key = self._highlighted
        if key in self.chosen:
            at = self.chosen.index(key)
            self.chosen.remove(key)
            self.chosen.insert(max(at + step, 0), key)
            self._list(key)

    @on(Input.Submitted)
    def _add(self, event: Input.Submitted) -> None:
        """Add the typed column."""
        key, problem = event.value.strip(), ""
        if not key:
            self.action_apply()
        elif key in (*self._offered, *self._others):
            if key not in self.chosen:
                self.chosen.append(key)
            event.input.value = ""
            self._list(key)
        else:
            hint = nearest(key, [*self._offered, *self._others])
            problem = f"No run has the option or term {key}.{f' {hint}' if hint else ''}"
        self.query_one("#ask-problem", Static).update(Text(visible(problem)))

    def action_usual(self) -> None:
        """Return to the usual columns."""
        self.dismiss(())

    def action_apply(self) -> None:
        self.dismiss(tuple(self.chosen))
