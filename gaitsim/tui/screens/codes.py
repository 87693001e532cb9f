"""Dialogs for challenge codes: show a code to copy and ask for a pasted one."""

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Static, TextArea

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.sharing.challenge import Challenge, code_of
from gaitsim.tui.actions import bindings
from gaitsim.tui.screens.base import GaitScreen

LONGEST = 100_000  # maximum number of characters in a command's argument


class ShowCode(ModalScreen[None]):
    """Show a code and copy it to the clipboard.

    Args:
        title: title of the individual.
        code: challenge code of the individual.
    """

    BINDINGS = bindings("code show")
    DEFAULT_CSS = """
    ShowCode TextArea { height: 10; margin: 1 0; padding: 0 1; border: none; }
    """

    def __init__(self, title: str, code: str) -> None:
        super().__init__()
        self._title, self._code = title, code

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "c: copy · esc: close"
            yield Static(Text(visible(self._title)), classes="dialog-title")
            about = (
                f"Copied: a challenge code of {len(self._code):,} characters. Anyone can play it."
            )
            yield Static(Text(about), classes="dialog-about")
            yield TextArea(self._code, read_only=True, id="code")
            yield Static(Text("$ gaitsim verify CODE"), classes="dialog-about")

    def on_mount(self) -> None:
        self.app.copy_to_clipboard(self._code)

    def action_copy(self) -> None:
        self.app.copy_to_clipboard(self._code)
        self.notify(f"{len(self._code):,} characters", title="Copied", markup=False)


class AskCode(ModalScreen[str | None]):
    """Ask for a challenge code, which may have line breaks; return it on one line, or None."""

    BINDINGS = bindings("code ask")
    DEFAULT_CSS = """
    AskCode TextArea { height: 10; margin-top: 1; padding: 0 1; border: none; }
    """

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "ctrl+s: verify · esc: cancel"
            yield Static(Text("Paste a challenge code"), classes="dialog-title")
            yield TextArea(id="code")
            yield Static(id="code-problem", classes="problem")
            with Horizontal(classes="dialog-buttons"):
                yield Button("Verify", variant="primary", compact=True, id="code-verify")
                yield Button("Cancel", compact=True, id="code-cancel")

    def on_mount(self) -> None:
        self.query_one(TextArea).focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "code-verify":
            self.action_submit()
        else:
            self.dismiss()

    def action_submit(self) -> None:
        """Return the code, or show why it is invalid."""
        text = "".join(self.query_one(TextArea).text.split())
        try:
            Challenge.read(text)
            if len(text) > LONGEST:
                raise GaitsimError(
                    f"the code has {len(text):,} characters",
                    allowed=f"at most {LONGEST:,} in this dialog",
                    remedy="save it to a file and run: gaitsim verify FILE",
                )
        except GaitsimError as error:
            problem = Text(visible_lines(str(error)))
            self.query_one("#code-problem", Static).update(problem)
        else:
            self.dismiss(text)


async def show_code(screen: GaitScreen, individual: Individual) -> None:
    """Show the challenge code of an individual in a dialog and copy it."""
    try:
        code = await screen.in_thread(code_of, individual)
    except GaitsimError as error:
        screen.gaitsim.show_error(error)
    else:
        screen.app.push_screen(ShowCode(individual.title, code))
