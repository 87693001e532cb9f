"""Asks for one line, such as the name of a file."""

from collections.abc import Callable
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from gaitsim.errors import GaitsimError


class Ask(ModalScreen[str | None]):
    """Asks; dismissed with what was typed, or None.

    Args:
        question: what is asked for.
        value: what stands there at first.
        check: raises a GaitsimError where an answer will not do.
        about: more about it.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Cancel", id="ask.cancel", tooltip="Leave it"),
    ]

    def __init__(
        self,
        question: str,
        value: str = "",
        check: Callable[[str], object] | None = None,
        about: str = "",
    ) -> None:
        super().__init__()
        self._question = question
        self._value = value
        self._check = check
        self._about = about

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "enter takes it, esc cancels"
            yield Static(Text(self._question), classes="dialog-title")
            if self._about:
                yield Static(Text(self._about), classes="dialog-about")
            yield Input(self._value, id="answer")
            yield Static(id="ask-problem", classes="problem")

    def on_input_submitted(self, event: Input.Submitted) -> None:
        answer = event.value.strip()
        try:
            if answer and self._check is not None:
                self._check(answer)
        except GaitsimError as error:
            self.query_one("#ask-problem", Static).update(Text(str(error)))
        else:
            self.dismiss(answer or None)
