"""Whether an experiment can run, or what is wrong first; and the command that runs it."""

from pathlib import Path

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.builder import Validation


class ExperimentStatus(Vertical):
    """The two of them, below the forms.

    Args:
        text: what is said at first.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text = text

    def compose(self) -> ComposeResult:
        yield Static(self._text, id="status")
        yield Static(id="command", classes="command")

    def show(self, found: Validation, run: Path, command: str) -> None:
        """Say how a builder stands, whose run would be `run`."""
        self.query_one("#command", Static).update(Text(visible(f"$ {command}")))
        if not found.problems:
            self.tell(f"✓ It can run, as {run}")
            return
        key, first = next(iter(found.problems.items()))
        more = f"  (and {len(found.problems) - 1} more)" if len(found.problems) > 1 else ""
        parts = [first.what, first.allowed and f"allowed: {first.allowed}", first.remedy]
        place = f"{key}: " if key else ""
        self.tell(f"✗ {place}{'; '.join(filter(None, parts))}{more}", wrong=True)

    def tell(self, text: str, *, wrong: bool = False) -> None:
        """Say something else."""
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))
