"""The app: its first screen, its actions on all screens, and questions when it quits."""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from textual import work
from textual.command import Provider
from textual.notifications import SeverityLevel
from textual.screen import Screen
from textual.types import CSSPathType

from gaitsim.errors import GaitsimError
from gaitsim.tui.commands import Commands
from gaitsim.tui.keys import bindings, broken
from gaitsim.tui.run_ends import RunEnd, RunEnds, desktop_notification, processes_in
from gaitsim.tui.screens.base import CommandPalette, GaitScreen
from gaitsim.tui.screens.home import Home
from gaitsim.tui.shell import Shell

if TYPE_CHECKING:
    from gaitsim.tui.screens.questions import Choose

PERIOD = 1.0  # seconds between two checks for the ends of background runs
PATIENCE = 10.0  # seconds to wait for a run to finish its generation
NAMES = 5  # maximum number of runs to name


class GaitsimApp(Shell):
    """The app: create, watch, steer and replay runs.

    Screens are imported when they are first shown, so the first paint does not wait for
    NumPy's compilers or plotting libraries.

    Args:
        first: function that creates the first screen.
        settings: arguments of `Shell`.
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
        first: Callable[[], Screen[None]] = Home,
        **settings: Any,
    ) -> None:
        super().__init__(folder, **settings)
        self._first = first
        self._ends, self._looking = RunEnds(folder), asyncio.Lock()

    def get_default_screen(self) -> Screen[None]:
        """Return the first screen."""
        return self._first()

    def action_command_palette(self) -> None:
        if not isinstance(self.screen, CommandPalette):
            self.push_screen(CommandPalette(id="--command-palette"))

    def action_help(self) -> None:
        from gaitsim.tui.screens.help import Help

        self.push_screen(Help(self.screen))

    def action_tasks(self) -> None:
        from gaitsim.tui.screens.tasks import TaskList

        self.push_screen(TaskList())

    def action_copy_command(self) -> None:
        self.copy(self._command())

    def _command(self) -> str:
        return self.screen.command_line() if isinstance(self.screen, GaitScreen) else ""

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "copy_command":
            return bool(self._command())
        if action == "tasks":
            return bool(self.tasks.all) and not self.screen.query("#tasks")
        return super().check_action(action, parameters)

    def on_mount(self) -> None:
        """Watch the background runs, and show the errors of packages' screens."""
        for error in broken:
            self.show_error(error)
        self.set_interval(PERIOD, self._look_for_ends)

    @work(group="ends")
    async def _look_for_ends(self) -> None:
        """Report the background runs that have ended."""
        if self._looking.locked():
            return
        async with self._looking:
            for end in await asyncio.to_thread(self._ends.poll):
                self._report_end(end)

    def _report_end(self, end: RunEnd) -> None:
        severity: SeverityLevel = "error" if end.failed else "information"
        self.notify(end.text, title=end.title, severity=severity, markup=False, timeout=10)
        if self.notifies_desktop and self._driver is not None and not self.is_headless:
            self._driver.write(desktop_notification(f"{end.title}: {end.text}"))

    @work(group="leaving", exclusive=True)
    async def action_quit(self) -> None:  # type: ignore[override]
        """Quit, if all screens may be closed and the user agrees."""
        for screen in reversed(self.screen_stack):
            if isinstance(screen, GaitScreen) and not await screen.may_leave():
                return
        if await self._may_quit():
            self.exit()

    async def _may_quit(self) -> bool:
        """Ask about unfinished work, stop tasks and runs as answered; return whether to quit."""
        from gaitsim.tui.screens.questions import Confirm

        if names := ", ".join(self.drafts):
            about = f"Not started and not saved: {names}"
            ask = Confirm("Discard the new run?", "Discard", about, danger=True)
            if not await self.push_screen_wait(ask):
                return False
        running = [task for task in self.tasks.all if task.running]
        if running:
            about = "\n".join(task.command for task in running)
            if not await self.push_screen_wait(Confirm("Stop the running tasks?", "Stop", about)):
                return False
        evolving = [one.run for one in await asyncio.to_thread(processes_in, self.folder)]
        answer = await self.push_screen_wait(_question(evolving)) if evolving else "k"
        if answer is None:
            return False
        if running:
            await self.tasks.stop_all()
        if answer == "s":
            await asyncio.gather(*(asyncio.to_thread(_stop, run) for run in evolving))
        return True


def _question(runs: Sequence[Path]) -> "Choose":
    from gaitsim.tui.screens.questions import Choose

    names = ", ".join(run.name for run in runs[:NAMES]) + (", …" if len(runs) > NAMES else "")
    about = (
        "Runs can continue without the app: 'gaitsim runs' lists them, 'gaitsim stop RUN' stops "
        "one. Stopped runs are saved and can be resumed."
    )
    answers = {"k": "Keep evolving", "s": "Stop and save"}
    return Choose(f"Quit? Runs in the background: {names}", answers, about)


def _stop(run: Path) -> None:
    """Stop a run; if its generation takes longer, it stops after the app has ended."""
    from gaitsim.live.process import stop

    with suppress(GaitsimError):  # it has just ended
        stop(run, PATIENCE)
