"""Verify runs, studies, trials and codes in the background; dialogs for challenge codes."""

from pathlib import Path

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Button, Static, TextArea

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import duration, visible, visible_lines
from gaitsim.sharing.challenge import Challenge, code_of
from gaitsim.storage.files.folder import command
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog, GaitScreen
from gaitsim.tui.screens.tasks import GLYPHS, bar
from gaitsim.tui.tasks import Task, TaskChanged

VERB, ALL = "verify", "--all"
LONGEST = 100_000  # maximum number of characters in a command's argument


class Verify(GaitScreen):
    """Repeat a run, a study or an adaptation, and show whether every bit is identical.

    Args:
        subject: folder of a run, a study or a comparison, or file of an adaptation; or a challenge
            code, whose individual is played instead.

    Attributes:
        job: verification on the screen.
    """

    HELP_TEXT = """
A quick run is evolved again from its own options and compared with its files bit by bit. Of a long
run, and of studies, comparisons and adaptations, a part is repeated. **All** repeats everything, a
run until the first difference, which can take as long as it took at first.

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
        self._is_file = isinstance(subject, Path)
        self.job: Task | None = None

    def content(self) -> ComposeResult:
        yield Static(id="verify-state")
        with VerticalScroll():
            yield Static(id="verify-result")
        yield Static(id="verify-command", classes="command")

    def on_mount(self) -> None:
        """Show the latest result for this run, or start a verification."""
        name = visible(self._subject) if self._is_file else "a challenge code"
        self.sub_title = f"verify {name}"
        own = [task for task in self.gaitsim.tasks.all
               if task.arguments[:2] == (VERB, self._subject)]  # fmt: skip
        if own:
            self.job = own[-1]
            self._show()
        else:
            self._start_verification()
        self.set_interval(0.5, self._tick)

    def _start_verification(self, *options: str) -> None:
        columns = self.size.width - 4  # of the padding
        self.job = self.gaitsim.tasks.start((VERB, self._subject, *options), columns=columns)
        self._show()

    def on_task_changed(self, event: TaskChanged) -> None:
        """Show the progress and the result."""
        if event.task is self.job:
            self._show()

    def _tick(self) -> None:
        if self.job is not None and self.job.running:
            self._show()

    def _show(self) -> None:
        task = self.job
        assert task is not None
        glyph, word, colour = _verdict(task)
        state = Text(f"{glyph} {word}", f"bold ${colour}")
        parts = [bar(task)] if task.running and bar(task) else []
        parts.append(f"{'for' if task.running else 'after'} {duration(task.seconds)}")
        state.append("".join(f"   {part}" for part in parts), "dim")
        self.query_one("#verify-state", Static).update(state)
        lines = [*task.output, *task.notices]
        if task.error is not None:
            lines.append(task.message)
        elif task.running:
            lines.append(
                "Repeating and comparing …" if self._is_file else "Playing the individual …"
            )
        self.query_one("#verify-result", Static).update(Text("\n".join(lines)))
        self.query_one("#verify-command", Static).update(Text(f"$ {visible(task.command)}"))
        self.refresh_bindings()

    def action_some(self) -> None:
        self._start_verification()

    def action_all(self) -> None:
        self._start_verification(ALL)

    def action_stop(self) -> None:
        if self.job is not None:
            self.gaitsim.tasks.stop(self.job)

    def command_line(self) -> str:
        return self.job.command if self.job else command(VERB, self._subject)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        running = self.job is not None and self.job.running
        if action in ("some", "all"):
            return not running and self._is_file
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


class ShowCode(Dialog[None]):
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


class AskCode(Dialog[str | None]):
    """Ask for a text with a challenge code; return the code on one line, or None."""

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
        try:
            code = Challenge.read(self.query_one(TextArea).text).code
            if len(code) > LONGEST:
                raise GaitsimError(
                    f"the code has {len(code):,} characters",
                    allowed=f"at most {LONGEST:,} in this dialog",
                    remedy="save it to a file and run: gaitsim verify FILE",
                )
        except GaitsimError as error:
            problem = Text(visible_lines(str(error)))
            self.query_one("#code-problem", Static).update(problem)
        else:
            self.dismiss(code)


async def show_code(screen: GaitScreen, individual: Individual) -> None:
    """Show the challenge code of an individual in a dialog and copy it."""
    try:
        code = await screen.in_thread(code_of, individual)
    except GaitsimError as error:
        screen.gaitsim.show_error(error)
    else:
        screen.app.push_screen(ShowCode(individual.title, code))
