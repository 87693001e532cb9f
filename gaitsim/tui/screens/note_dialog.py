"""A dialog for the note of a run."""

from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Static, TextArea

from gaitsim.render.terminal.text import visible
from gaitsim.tui.actions import bindings
from gaitsim.tui.screens.questions import Confirm


class NoteDialog(ModalScreen[str | None]):
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

    @work(exclusive=True)
    async def action_cancel(self) -> None:
        """Close without saving; ask first if the note was edited."""
        edited = self.query_one(TextArea).text != self._note
        question = Confirm("Discard the changes?", "Discard", danger=True)
        if not edited or await self.app.push_screen_wait(question):
            self.dismiss(None)
