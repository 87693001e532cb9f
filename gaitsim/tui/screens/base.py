"""The base class of all screens."""

import asyncio
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol, TypeVar, cast

from textual.binding import Binding
from textual.events import Key
from textual.screen import Screen

from gaitsim.errors import GaitsimError
from gaitsim.tui.actions import bindings
from gaitsim.tui.lean import Mirror
from gaitsim.tui.tasks import Task, Tasks

if TYPE_CHECKING:
    from gaitsim.individual import Member, Which
    from gaitsim.steering import Drive
    from gaitsim.tui.builder import ExperimentBuilder

T = TypeVar("T")


class PaletteCommand(NamedTuple):
    """A command in the palette: its title, one line of help, and the function to call."""

    title: str
    help: str
    do: Callable[[], object]


class Listed(Protocol):
    """A run in a list: its folder and the problem if it cannot be read."""

    @property
    def path(self) -> Path: ...
    @property
    def problem(self) -> GaitsimError | None: ...


class Navigator(Protocol):
    """The app's interface for its screens, so that they need not import the app.

    Attributes:
        folder: folder that holds the runs.
        clock: function that returns the time in seconds since 1970.
        tasks: commands in the background.
        mirror: content of the terminal, and the number of bytes sent to it.
        drafts: unsaved new runs by preset, the latest last.
    """

    folder: Path
    clock: Callable[[], float]
    tasks: Tasks
    mirror: Mirror
    drafts: "dict[str, ExperimentBuilder]"

    def open_run(self, run: Path, *, resume: bool = False) -> None: ...
    def open_new(self, experiment: str | None = None) -> None: ...
    def open_replay(
        self,
        run: Path,
        which: "Which" = None,
        beside: Path | None = None,
        damage: Sequence[str] = (),
    ) -> None: ...
    def open_laboratory(self, run: Path, which: "Which" = None) -> None: ...
    def open_map(self, run: Path, member: "Member | None" = None) -> None: ...
    def open_why(self, run: Path, which: "Which" = None) -> None: ...
    def open_steering(self, load: "Callable[[], Drive]", line: str) -> None: ...
    def open_compare(self, runs: list[Path]) -> None: ...
    def open_plugins(self) -> None: ...
    def open_export(
        self,
        run: Path,
        which: "Which" = None,
        others: Sequence[Path] = (),
        damage: Sequence[str] = (),
    ) -> object: ...
    def open_files(self, run: Path) -> None: ...
    def start_task(self, arguments: Sequence[str], *, opens: bool = False) -> Task: ...
    def leave(self, screen: Screen[None]) -> object: ...
    def show_error(self, error: GaitsimError) -> None: ...
    def palette(self) -> Iterable[PaletteCommand]: ...


class GaitScreen(Screen[None]):
    """A screen with a help text, whose keys have ids so that users can remap them.

    `check_action` disables bindings that do not apply. The footer hides them, and the command
    palette shows the reason, which `obstacle` returns.

    Attributes:
        HELP_TEXT: purpose and use of the screen, in Markdown.
    """

    HELP_TEXT: ClassVar[str] = ""
    BINDINGS = bindings("screen")

    @property
    def gaitsim(self) -> Navigator:
        """The app."""
        return cast(Navigator, self.app)

    def command_line(self) -> str:
        """Return the equivalent command line, or '' if there is none."""
        return ""

    @property
    def run_to_verify(self) -> Path | None:
        """The run on the screen, or None if it has no generation to reproduce."""
        return None

    def palette(self) -> Iterable[PaletteCommand]:
        """Return the available commands that have no key."""
        return ()

    async def may_leave(self) -> bool:
        """Return whether the screen may be closed, after asking or saving where necessary.

        It runs in a worker, so it may await `self.app.push_screen_wait(…)`.
        """
        return True

    async def in_thread(self, work: Callable[..., T], *arguments: object) -> T:
        """Call a function in a thread; cancel the awaiting worker if the screen was closed."""
        result = await asyncio.to_thread(work, *arguments)
        if not self.app.is_running or self not in self.app.screen_stack:
            raise asyncio.CancelledError
        return result

    def is_busy(self, group: str) -> bool:
        """Return whether a worker of a group is running."""
        ours = (worker for worker in self.workers if worker.node is self)
        return any(worker.group == group and worker.is_running for worker in ours)

    def open_listed(self, run: Listed | None) -> None:
        """Open a listed run, or report why it cannot be read."""
        if run is None:
            return
        if run.problem is not None:
            self.gaitsim.show_error(run.problem)
        else:
            self.gaitsim.open_run(run.path)

    def action_studies(self) -> None:
        """Show studies and comparisons."""
        from gaitsim.tui.screens.studies import Studies

        self.app.push_screen(Studies())

    def action_verify(self) -> None:
        """Reproduce generations of the run and compare every bit."""
        from gaitsim.tui.screens.verify import Verify

        if self.run_to_verify is not None:
            self.app.push_screen(Verify(self.run_to_verify))

    def action_back(self) -> None:
        """Return to the previous screen."""
        self.gaitsim.leave(self)

    def obstacle(self, action: str) -> str:
        """Return why an action is unavailable and how to enable it; '' if it is available.

        The command palette shows the reason.
        """
        return ""

    def on_key(self, event: Key) -> None:
        """Report why a key of the screen is unavailable."""
        if self.focused is not None and self.focused.check_consume_key(event.key, event.character):
            return
        for kind in type(self).__mro__:
            for binding in kind.__dict__.get("BINDINGS", ()):
                if not isinstance(binding, Binding) or event.key not in binding.key.split(","):
                    continue
                why = self.obstacle(binding.action)
                if why and event.key not in self.active_bindings:  # slow: checks all keys
                    self.notify(why, title=binding.description, markup=False)
                    return

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether an action is available."""
        if action == "back":
            return len(self.app.screen_stack) > 1
        if action == "verify":
            return self.is_mounted and self.run_to_verify is not None
        if self.is_mounted and self.obstacle(action):
            return False
        return super().check_action(action, parameters)
