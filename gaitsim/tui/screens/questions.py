"""Small dialogs: questions answered by a button, a line of text, or the text of a note."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Key
from textual.suggester import Suggester
from textual.widgets import Button, Input, Static, TextArea

from gaitsim.errors import GaitsimError, nearest
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog
from gaitsim.tui.widgets.lists import ChoiceList


class Confirm(Dialog[bool]):
    """Ask a yes-or-no question; return whether the answer was yes.

    Args:
        question: question in one sentence.
        yes: label of the button that agrees, a verb.
        about: consequences of a yes.
        danger: whether the action cannot be undone; then "Cancel" has the focus.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        *bindings("confirm"),
        Binding("left,right,tab", "app.focus_next", show=False),
    ]

    def __init__(self, question: str, yes: str, about: str = "", *, danger: bool = False) -> None:
        super().__init__()
        self._question, self._yes, self._about, self._danger = question, yes, about, danger

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = f"y: {self._yes.lower()} · n or esc: cancel"
            yield from _heading(self._question, self._about)
            with Horizontal(classes="dialog-buttons"):
                variant = "error" if self._danger else "primary"
                yield Button(Text(self._yes), variant=variant, id="yes")  # type: ignore[arg-type]
                yield Button("Cancel", id="no")

    def on_mount(self) -> None:
        """Focus the safe button."""
        self.query_one("#no" if self._danger else "#yes", Button).focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.dismiss(event.button.id == "yes")


class Choose(Dialog[str | None]):
    """Ask a question with several answers; return the key of one, or None.

    Args:
        question: question in one sentence.
        answers: labels of the answers by key; the first has the focus.
        about: consequences of the answers.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        *bindings("choose"),
        Binding("left", "app.focus_previous", show=False),
        Binding("right", "app.focus_next", show=False),
    ]

    def __init__(self, question: str, answers: Mapping[str, str], about: str = "") -> None:
        super().__init__()
        self._question, self._answers, self._about = question, answers, about

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            hints = [f"{key}: {label.lower()}" for key, label in self._answers.items()]
            box.border_subtitle = " · ".join([*hints, "esc: cancel"])
            yield from _heading(self._question, self._about)
            with Horizontal(classes="dialog-buttons"):
                for number, (key, label) in enumerate(self._answers.items()):
                    text = Text.assemble((key, "underline"), f" {label}")
                    variant = "default" if number else "primary"
                    yield Button(text, variant=variant, id=f"choose-{key}")  # type: ignore[arg-type]
                yield Button("Cancel", id="choose-cancel")

    def on_button_pressed(self, event: Button.Pressed) -> None:
        key = (event.button.id or "").removeprefix("choose-")
        self.dismiss(key if key in self._answers else None)

    def on_key(self, event: Key) -> None:
        if event.key in self._answers:
            self.dismiss(event.key)


class Ask(Dialog[str | None]):
    """Ask for a line of text, such as a file name; return it, or None.

    Args:
        question: question in one sentence.
        value: initial text.
        check: function that raises a GaitsimError for an invalid answer.
        about: details below the question.
        words: words to complete the last word of the answer with.
        empty: whether the answer may be empty.
    """

    BINDINGS = bindings("ask")

    def __init__(
        self,
        question: str,
        value: str = "",
        check: Callable[[str], object] = str,
        about: str = "",
        *,
        words: Sequence[str] = (),
        empty: bool = False,
    ) -> None:
        super().__init__()
        self._question, self._value, self._check, self._about = question, value, check, about
        self._words, self._empty = words, empty

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "enter: accept · esc: cancel"
            yield from _heading(self._question, self._about)
            yield Input(self._value, suggester=WordSuggester(self._words), id="answer")
            yield Static(id="ask-problem", classes="problem")
            with Horizontal(classes="dialog-buttons"):
                yield Button("OK", variant="primary", compact=True, id="ask-ok")
                yield Button("Cancel", compact=True, id="ask-cancel")

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "ask-ok":
            self._submit()
        else:
            self.dismiss()

    def on_input_submitted(self) -> None:
        self._submit()

    def _submit(self) -> None:
        answer = self.query_one("#answer", Input).value.strip()
        try:
            if answer:
                self._check(answer)
        except GaitsimError as error:
            self.query_one("#ask-problem", Static).update(Text(str(error)))
        else:
            self.dismiss(answer if answer or self._empty else None)


class WordSuggester(Suggester):
    """Completes the last word of a field.

    Args:
        words: known words.
    """

    def __init__(self, words: Sequence[str]) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self._words = words

    async def get_suggestion(self, value: str) -> str | None:
        last = value.rpartition(" ")[2].lstrip("+-")
        found = (word for word in self._words if last and word.startswith(last))
        return next((value + word.removeprefix(last) for word in found), None)


class Pick(Dialog[tuple[str, str] | None]):
    """Show a list to choose from; return what to do and the key of the chosen item, or None.

    What to do is `choose` for Enter, or the name of an action of the class.

    Args:
        question: heading.
        items: lines by key.
        about: details below the heading.
        hints: keys shown at the lower border.
    """

    def __init__(
        self, question: str, items: Mapping[str, Text], about: str = "", hints: str = ""
    ) -> None:
        super().__init__()
        self._question, self._items, self._about, self._hints = question, items, about, hints

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = self._hints
            yield from _heading(self._question, self._about)
            yield ChoiceList(*self._items.values(), id="items")

    def on_option_list_option_selected(self, event: ChoiceList.OptionSelected) -> None:
        self.action_do("choose")

    def action_do(self, what: str) -> None:
        """Close the dialog, which returns what to do with the highlighted item."""
        at = self.query_one(ChoiceList).highlighted
        self.dismiss((what, "" if at is None else [*self._items][at]))


class PickTrashed(Pick):
    """A list of deleted runs."""

    BINDINGS = bindings("trash")


def _heading(question: str, about: str) -> Iterator[Static]:
    yield Static(Text(visible(question)), classes="dialog-title")
    if about:
        yield Static(Text(visible_lines(about)), classes="dialog-about")


class NoteDialog(Dialog[str | None]):
    """Edit a note; return it, or None to leave it unchanged.

    Args:
        run: name of the run.
        note: current note.
    """

    BINDINGS = bindings("note")
    DEFAULT_CSS = """
    NoteDialog TextArea { height: 8; margin-top: 1; padding: 0 1; border: none; }
    """

    def __init__(self, run: str, note: str) -> None:
        super().__init__()
        self._run, self._note = run, note

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "ctrl+s: save · esc: cancel"
            yield Static(Text(visible(f"Note on the run {self._run}")), classes="dialog-title")
            yield TextArea(self._note, id="note")
            with Horizontal(classes="dialog-buttons"):
                yield Button("Save", variant="primary", compact=True, id="note-save")
                yield Button("Cancel", compact=True, id="note-cancel")

    def on_mount(self) -> None:
        """Put the cursor at the end of the note."""
        area = self.query_one(TextArea)
        area.move_cursor(area.document.end)
        area.focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "note-save":
            self.action_save()
        else:
            self.action_cancel()

    def action_save(self) -> None:
        self.dismiss(self.query_one(TextArea).text)

    @work(group="ask", exclusive=True)
    async def action_cancel(self) -> None:
        """Close without saving; ask first if the note was edited."""
        edited = self.query_one(TextArea).text != self._note
        question = Confirm("Discard the changes?", "Discard", danger=True)
        if not edited or await self.app.push_screen_wait(question):
            self.dismiss(None)


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
