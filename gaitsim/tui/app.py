"""The app: its screens, and the navigation between them."""

import asyncio
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from textual import work
from textual.command import Provider
from textual.dom import DOMNode
from textual.driver import Driver
from textual.events import Key
from textual.filter import LineFilter
from textual.screen import Screen
from textual.types import CSSPathType
from textual.widgets import Input

from gaitsim.errors import GaitsimError
from gaitsim.tui.actions import bindings
from gaitsim.tui.commands import Commands
from gaitsim.tui.config import Config, format_problem, remember_theme
from gaitsim.tui.lean import Mirror, lean_driver
from gaitsim.tui.plain import PlainText
from gaitsim.tui.screens.base import GaitScreen, Navigator, PaletteCommand
from gaitsim.tui.screens.home import Home
from gaitsim.tui.tasks import Task, TaskChanged, Tasks
from gaitsim.tui.themes import DEFAULT, THEMES
from gaitsim.tui.vi import ViKeys

if TYPE_CHECKING:
    from gaitsim.individual import Member, Which
    from gaitsim.steering import Drive
    from gaitsim.tui.builder import ExperimentBuilder

_PLAIN = PlainText()


class GaitsimApp(ViKeys):
    """The app: create, watch, steer and replay runs.

    Screens are imported when they are first shown, so the first paint does not wait for
    NumPy's compilers or plotting libraries.

    Args:
        folder: folder that holds the runs.
        config: the user's settings; None for the defaults.
        theme: name of a theme; overrides the settings.
        clock: function that returns the time in seconds since 1970.
        first: function that creates the first screen.

    Attributes:
        tasks: commands in the background.
        mirror: content of the terminal.
        drafts: unsaved new runs by preset, the latest last.
    """

    TITLE = "gaitsim"
    CSS_PATH: ClassVar[CSSPathType | None] = Path(__file__).with_name("styles.tcss")
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (120, "-wide")]  # noqa: RUF012 (as Textual has it)
    VERTICAL_BREAKPOINTS = [(0, "-short"), (36, "-tall")]  # noqa: RUF012
    COMMANDS: ClassVar[set[type[Provider] | Callable[[], type[Provider]]]] = {Commands}
    BINDINGS = bindings("app")

    def __init__(
        self,
        folder: Path = Path("runs"),
        *,
        config: Config | None = None,
        theme: str | None = None,
        clock: Callable[[], float] = time.time,
        first: Callable[[], Screen[None]] = Home,
    ) -> None:
        super().__init__()
        self.folder = folder
        self._first = first
        self.clock = clock
        self.tasks = Tasks(self._task_changed)
        self.drafts: dict[str, ExperimentBuilder] = {}
        self._config = config
        for ours in THEMES:
            self.register_theme(ours)
        self.theme = theme or (config.theme if config else None) or DEFAULT

    def get_driver_class(self) -> type[Driver]:
        """Return a driver that sends only changed cells."""
        self.mirror = Mirror()
        driver = super().get_driver_class()
        # On Windows, Textual writes in chunks that may end within a sequence.
        return driver if sys.platform == "win32" else lean_driver(driver, self.mirror)

    def on_resize(self) -> None:
        """Resend the whole screen."""
        self.mirror.forget()

    def get_line_filters(self) -> Sequence[LineFilter]:
        """Return the filters applied to each line before it is drawn."""
        return [*super().get_line_filters(), _PLAIN]

    def get_default_screen(self) -> Screen[None]:
        """Return the first screen."""
        return self._first()

    def on_mount(self) -> None:
        """Apply the user's keys; report problems of the settings."""
        config = self._config
        if config is None:
            return
        self._report(config.path, config.problems)
        if config.keys:
            from gaitsim.tui.keys import valid_keys

            self.set_keymap(valid_keys(config))
            self._check_keys(config)

    @work(group="keys")
    async def _check_keys(self, config: Config) -> None:
        from gaitsim.tui.keys import find_problems

        self._report(config.path, await asyncio.to_thread(find_problems, config))

    def _report(self, path: Path, problems: Sequence[GaitsimError]) -> None:
        """Report the problems of the settings in one message."""
        if problems:
            lines = "\n".join(map(format_problem, problems))
            self.notify(lines, title=str(path), severity="warning", markup=False, timeout=15)

    # Navigation

    def open_run(self, run: Path, *, resume: bool = False) -> None:
        """Show a run live; `resume` continues it immediately."""
        from gaitsim.tui.screens.live import Live

        # A double click arrives twice.
        if not (isinstance(self.screen, Live) and self.screen.run == run):
            self.push_screen(Live(run, resume=resume))

    def open_new(self, experiment: str | None = None) -> None:
        """Create a new run from a preset's name or an experiment file."""
        from gaitsim.tui.screens.new import New

        self.push_screen(New(experiment))

    def open_replay(
        self,
        run: Path,
        which: "Which" = None,
        beside: Path | None = None,
        damage: Sequence[str] = (),
    ) -> None:
        """Replay the champion or a different individual, beside one of a second run if given.

        The body has the given damage.
        """
        from gaitsim.tui.screens.replay import Replay

        self.push_screen(Replay(run, which, beside, damage))

    def open_laboratory(self, run: Path, which: "Which" = None) -> None:
        """Damage the body of a run, and adapt its gait."""
        from gaitsim.tui.screens.laboratory import Laboratory

        self.push_screen(Laboratory(run, which))

    def open_map(self, run: Path, member: "Member | None" = None) -> None:
        """Show the archive of a run as a map, with the cursor on a member or the best."""
        from gaitsim.tui.screens.atlas import Map

        self.push_screen(Map(run, member))

    def open_why(self, run: Path, which: "Which" = None) -> None:
        """Explain the score of the champion or a different individual."""
        from gaitsim.tui.screens.why import Why

        self.push_screen(Why(run, which))

    def open_steering(self, load: "Callable[[], Drive]", line: str) -> None:
        """Let the user steer the body that `load` returns; `line` is the equivalent command."""
        from gaitsim.tui.screens.steering import Steering

        self.push_screen(Steering(load, line))

    def open_compare(self, runs: list[Path]) -> None:
        """Compare the curves of several runs."""
        from gaitsim.tui.screens.compare import Compare

        self.push_screen(Compare(runs))

    def open_plugins(self) -> None:
        """Show installed plugins."""
        from gaitsim.tui.screens.plugins import Plugins

        self.push_screen(Plugins())

    @work
    async def open_export(
        self,
        run: Path,
        which: "Which" = None,
        others: Sequence[Path] = (),
        damage: Sequence[str] = (),
    ) -> None:
        """Ask what to export from a run, for an individual, with other runs to compare."""
        from gaitsim.tui.screens.export_dialog import ExportDialog

        answer = await self.push_screen_wait(ExportDialog(run, which, others, damage))
        if answer == "files":
            self.open_files(run)
        elif answer:
            self.start_task(answer)

    @work
    async def verify_code(self) -> None:
        """Ask for a challenge code, and verify it."""
        from gaitsim.tui.screens.codes import AskCode
        from gaitsim.tui.screens.verify import Verify

        code = await self.push_screen_wait(AskCode())
        if code:
            self.push_screen(Verify(code))

    def open_files(self, run: Path) -> None:
        """Show the files exported from a run."""
        from gaitsim.tui.screens.files import Files

        self.push_screen(Files(run))

    def start_task(self, arguments: Sequence[str], *, opens: bool = False) -> Task:
        """Run a gaitsim command in the background; with `opens`, open the file it writes."""
        task = self.tasks.start(arguments, opens=opens)
        if not self.screen.query("#tasks"):
            self.notify(
                task.command, title="Running in the background; press t to see it", markup=False
            )
        return task

    @work(group="leaving", exclusive=True)
    async def leave(self, screen: Screen[None]) -> None:
        """Close a screen, if it may be closed."""
        if screen.is_current and len(self.screen_stack) > 1 and await _may_leave(screen):
            screen.dismiss()

    def show_error(self, error: GaitsimError) -> None:
        """Show an error as plain text."""
        self.notify(str(error), title="", severity="error", markup=False, timeout=10)

    # Actions of all screens

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield commands without a key of their own."""
        for name in sorted(self.available_themes):
            if name != self.theme and not name.startswith("ansi"):
                do = partial(self.choose_theme, name)
                yield PaletteCommand(
                    f"Theme: {name}", "Switch to this theme and save the choice", do
                )
        yield PaletteCommand(
            "Verify a code", "Check the score of a pasted challenge code", self.verify_code
        )
        yield PaletteCommand("Screenshot", "Save this screen as SVG", self.deliver_screenshot)

    def choose_theme(self, name: str) -> None:
        """Change the theme and store it in the settings."""
        self.theme = name
        if self._config is not None:
            try:
                remember_theme(self._config.path, name)
            except GaitsimError as error:
                self.show_error(error)

    def action_help(self) -> None:
        from gaitsim.tui.screens.help import Help

        self.push_screen(Help(self.screen))

    def action_jump(self) -> None:
        from gaitsim.tui.jump import Jump

        self.push_screen(Jump(self.screen), lambda widget: widget and widget.focus() and None)

    def action_tasks(self) -> None:
        from gaitsim.tui.screens.tasks import TaskList

        self.push_screen(TaskList())

    def action_copy_command(self) -> None:
        command = self._command()
        self.copy_to_clipboard(command)
        self.notify(command, title="Copied", markup=False)

    def _command(self) -> str:
        return self.screen.command_line() if isinstance(self.screen, GaitScreen) else ""

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "copy_command":
            return bool(self._command())
        if action == "tasks":
            return bool(self.tasks.all) and not self.screen.query("#tasks")
        return super().check_action(action, parameters)

    @work(group="leaving", exclusive=True)
    async def _quit(self) -> None:
        for screen in reversed(self.screen_stack):
            if not await _may_leave(screen):
                return
        from gaitsim.tui.quitting import may_quit

        if await may_quit(self, self.drafts, self.tasks, self.folder):
            self.exit()

    def on_key(self, event: Key) -> None:
        """Type a letter into a field that received the focus after the key was pressed.

        In a paste, the first letter may open a field for the others.
        """
        if isinstance(self.focused, Input) and event.character and event.is_printable:
            self.focused.insert_text_at_cursor(event.character)
            event.prevent_default()

    async def run_action(
        self,
        action: Any,
        default_namespace: DOMNode | None = None,
        namespaces: Mapping[str, DOMNode] | None = None,
    ) -> bool:
        """Run an action, unless its screen is not mounted yet.

        A key pressed on the previous screen would otherwise close a screen that is mounting.
        """
        if isinstance(default_namespace, Screen) and not default_namespace.is_mounted:
            return False
        return await super().run_action(action, default_namespace, namespaces)

    async def action_quit(self) -> None:
        self._quit()

    def _task_changed(self, task: Task) -> None:
        """Notify the screens of a change, and the user of the end of a task that no list shows."""
        self.screen.refresh_bindings()
        for screen in self.screen_stack:
            screen.post_message(TaskChanged(task))
        if task.state == "done" and task.opens and task.files:
            self.run_worker(self._open_file(task.files[0]), group="open")
            return
        if self.screen.query("#tasks"):
            return
        if task.state == "done":
            result = "\n".join(map(str, task.files)) or task.command
            self.notify(result, title="Done", markup=False)
        elif task.state == "failed":
            self.notify(
                task.message, title=task.command, severity="error", markup=False, timeout=10
            )

    async def _open_file(self, file: Path) -> None:
        from gaitsim.tui.opener import open_or_copy

        await open_or_copy(self, file, trusted=True)


async def _may_leave(screen: Screen[Any]) -> bool:
    return not isinstance(screen, GaitScreen) or await screen.may_leave()


if TYPE_CHECKING:  # checks that the app implements the interface for screens
    _navigator: Navigator = GaitsimApp()
