"""Small dialogs: questions answered by a button, a line of text, or a longer text."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar

from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Key
from textual.suggester import Suggester
from textual.widgets import Button, Input, Static, TextArea

from gaitsim.errors import GaitsimError
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
        separator: character between words.
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
        separator: str = " ",
        empty: bool = False,
    ) -> None:
        super().__init__()
        self._question, self._value, self._check, self._about = question, value, check, about
        self._suggester, self._empty = WordSuggester(words, separator), empty

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "enter: accept · esc: cancel"
            yield from _heading(self._question, self._about)
            yield Input(self._value, suggester=self._suggester, id="answer")
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
        separator: character between words.
    """

    def __init__(self, words: Sequence[str], separator: str) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self._words, self._separator = words, separator

    async def get_suggestion(self, value: str) -> str | None:
        last = value.rpartition(self._separator)[2].lstrip(" +-")
        found = (word for word in self._words if last and word.startswith(last))
        return next((value + word.removeprefix(last) for word in found), None)


class PickTrashed(Dialog[tuple[str, str] | None]):
    """Show deleted runs; return what to do and the key of the chosen run, or None.

    What to do is `choose` for Enter, or `empty` to delete all of them permanently.

    Args:
        question: heading.
        items: lines by key.
    """

    BINDINGS = bindings("trash")

    def __init__(self, question: str, items: Mapping[str, Text]) -> None:
        super().__init__()
        self._question, self._items = question, items

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "enter: restore · x: delete all permanently · esc: close"
            yield from _heading(self._question, "Runs stay in the trash for 30 days.")
            yield ChoiceList(*self._items.values(), id="items")

    def on_option_list_option_selected(self, event: ChoiceList.OptionSelected) -> None:
        self.action_do("choose")

    def action_do(self, what: str) -> None:
        """Close the dialog, which returns what to do with the highlighted run."""
        at = self.query_one(ChoiceList).highlighted
        self.dismiss((what, "" if at is None else [*self._items][at]))


def _heading(question: str, about: str) -> Iterator[Static]:
    yield Static(Text(visible(question)), classes="dialog-title")
    if about:
        yield Static(Text(visible_lines(about)), classes="dialog-about")


class AskText(Dialog[str | None]):
    """Ask for a text of several lines, such as a note; return it, or None.

    Args:
        question: heading.
        text: initial text.
        save: label of the button that accepts the text, a verb.
        check: function that returns the answer for a text, or raises a GaitsimError.
        about: details below the heading.
    """

    BINDINGS = bindings("note")
    DEFAULT_CSS = """
    AskText TextArea { height: 8; margin-top: 1; padding: 0 1; border: none; }
    """

    def __init__(
        self,
        question: str,
        text: str = "",
        save: str = "Save",
        check: Callable[[str], str] = str,
        about: str = "",
    ) -> None:
        super().__init__()
        self._question, self._text, self._about = question, text, about
        self._save, self._check = save, check

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = f"ctrl+s: {self._save.lower()} · esc: cancel"
            yield from _heading(self._question, self._about)
            yield TextArea(self._text, id="text")
            yield Static(id="ask-problem", classes="problem")
            with Horizontal(classes="dialog-buttons"):
                yield Button(self._save, variant="primary", compact=True, id="text-save")
                yield Button("Cancel", compact=True, id="text-cancel")

    def on_mount(self) -> None:
        """Put the cursor at the end of the text."""
        area = self.query_one(TextArea)
        area.move_cursor(area.document.end)
        area.focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "text-save":
            self.action_save()
        else:
            self.action_cancel()

    def action_save(self) -> None:
        """Return the text, or show why it is invalid."""
        try:
            self.dismiss(self._check(self.query_one(TextArea).text))
        except GaitsimError as error:
            self.query_one("#ask-problem", Static).update(Text(visible_lines(str(error))))

    @work(group="ask", exclusive=True)
    async def action_cancel(self) -> None:
        """Close without saving; ask first if the text was edited."""
        edited = self.query_one(TextArea).text != self._text
        question = Confirm("Discard the changes?", "Discard", danger=True)
        if not edited or await self.app.push_screen_wait(question):
            self.dismiss(None)
