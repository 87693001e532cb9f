"""A question with two answers."""

from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Static


class Confirm(ModalScreen[bool]):
    """Asks; dismissed with whether the answer was yes.

    Args:
        question: one sentence.
        yes: what the button does that agrees, a verb.
        about: what follows from it.
        danger: whether it cannot be undone; the other button has the focus then.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Yes", id="confirm.yes", tooltip="Do it"),
        Binding("n,escape", "answer(False)", "No", id="confirm.no", tooltip="Leave it"),
        Binding("left,right,tab", "app.focus_next", show=False),
    ]

    def __init__(self, question: str, yes: str, about: str = "", *, danger: bool = False) -> None:
        super().__init__()
        self._question = question
        self._yes = yes
        self._about = about
        self._danger = danger

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog"):
            yield Static(Text(self._question), classes="dialog-title")
            if self._about:
                yield Static(Text(self._about), classes="dialog-about")
            with Horizontal(classes="dialog-buttons"):
                variant = "error" if self._danger else "primary"
                yield Button(Text(self._yes), variant=variant, id="yes")  # type: ignore[arg-type]
                yield Button("Cancel", id="no")

    def on_mount(self) -> None:
        """Focus the button that does no harm."""
        self.query_one("#no" if self._danger else "#yes", Button).focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.dismiss(event.button.id == "yes")

    def action_answer(self, yes: bool) -> None:
        self.dismiss(yes)
