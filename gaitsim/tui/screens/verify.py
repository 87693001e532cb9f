"""Verify a run or a challenge code in the background and show the result."""

from pathlib import Path

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from gaitsim.render.terminal.text import visible
from gaitsim.runs.files.folder import command
from gaitsim.tui.actions import bindings
from gaitsim.tui.formatting import duration
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.tasks import GLYPHS, bar
from gaitsim.tui.tasks import Task, TaskChanged
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header

VERB, ALL = "verify", "--all"


class Verify(GaitScreen):
    """Reproduce generations of a run and show whether every bit is identical.

    Args:
        subject: folder of the run; or a challenge code, whose individual is played instead.
    """

    HELP_TEXT = """
Generations are reproduced from the run's own options and compared with its files bit by bit: the
first and the last in full, and the best individuals of some generations in between. **All**
re-evolves the whole run until the first difference, which can take as long as the run did.

Verification continues in the background when you leave the screen; return to see the result.
"""
    BINDINGS = bindings("verify")
    DEFAULT_CSS = """
    Verify {
        & #verify-state { height: auto; padding: 1 2 0 2; }
        & VerticalScroll { height: 1fr; padding: 1 2; }
        & #verify-command { height: auto; padding: 0 1; background: $surface; }
    }
    """

    def __init__(self, subject: Path | str) -> None:
        super().__init__()
        self._subject = str(subject)
        self._is_run = isinstance(subject, Path)
        self._job: Task | None = None

    def compose(self) -> ComposeResult:
        yield Header()
        yield Static(id="verify-state")
        with VerticalScroll():
            yield Static(id="verify-result")
        yield Static(id="verify-command", classes="command")
        yield Footer()

    def on_mount(self) -> None:
        """Show the latest result for this run, or start a verification."""
        name = visible(self._subject) if self._is_run else "a challenge code"
        self.sub_title = f"verify {name}"
        own = [task for task in self.gaitsim.tasks.all
               if task.arguments[:2] == (VERB, self._subject)]  # fmt: skip
        if own:
            self._job = own[-1]
            self._show()
        else:
            self._start_verification()
        self.set_interval(0.5, self._tick)

    def _start_verification(self, *options: str) -> None:
        self._job = self.gaitsim.start_task((VERB, self._subject, *options))
        self._show()

    def on_task_changed(self, event: TaskChanged) -> None:
        """Show the progress and the result."""
        if event.task is self._job:
            self._show()

    def _tick(self) -> None:
        if self._job is not None and self._job.running:
            self._show()

    def _show(self) -> None:
        task = self._job
        assert task is not None
        colours = self.app.theme_variables
        glyph, word, colour = _verdict(task)
        state = Text(f"{glyph} {word}", f"bold {colours[colour]}")
        parts = [bar(task)] if task.running and bar(task) else []
        parts.append(f"{'for' if task.running else 'after'} {duration(task.seconds)}")
        state.append("".join(f"   {part}" for part in parts), "dim")
        self.query_one("#verify-state", Static).update(state)
        lines = [*task.output, *task.notices]
        if task.error is not None:
            lines.append(task.message)
        elif task.running:
            lines.append(
                "Reproducing generations …" if self._is_run else "Playing the individual …"
            )
        self.query_one("#verify-result", Static).update(Text("\n".join(lines)))
        self.query_one("#verify-command", Static).update(Text(f"$ {visible(task.command)}"))
        self.refresh_bindings()

    def action_some(self) -> None:
        self._start_verification()

    def action_all(self) -> None:
        self._start_verification(ALL)

    def action_stop(self) -> None:
        if self._job is not None:
            self.gaitsim.tasks.stop(self._job)

    def command_line(self) -> str:
        return self._job.command if self._job else command(VERB, self._subject)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        running = self._job is not None and self._job.running
        if action in ("some", "all"):
            return not running and self._is_run
        if action == "stop":
            return running
        return super().check_action(action, parameters)


def _verdict(task: Task) -> tuple[str, str, str]:
    """Return the symbol, the word and the theme colour of a result."""
    if task.state == "failed" and task.error is None and task.output:
        return "✗", "different", "error"
    words = {
        "running": ("working", "secondary"),
        "done": ("identical", "success"),
        "failed": ("could not be verified", "error"),
        "stopped": ("stopped", "warning"),
    }
    return (GLYPHS[task.state], *words[task.state])
