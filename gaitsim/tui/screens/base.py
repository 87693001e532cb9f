"""The base class of all screens."""

import asyncio
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeVar, cast

from textual.binding import Binding, BindingType
from textual.screen import Screen

if TYPE_CHECKING:
    from gaitsim.tui.app import GaitsimApp

T = TypeVar("T")


class PaletteCommand(NamedTuple):
    """A command in the palette: its title, one line of help, and the function to call."""

    title: str
    help: str
    do: Callable[[], object]


class GaitScreen(Screen[None]):
    """A screen with a help text; its keys have ids, so that users can choose others.

    `check_action` refuses bindings that cannot work now: then neither the footer nor the
    command palette offers them.

    Attributes:
        HELP_TEXT: purpose and use of the screen, in Markdown.
    """

    HELP_TEXT: ClassVar[str] = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", id="screen.back", tooltip="To the screen before this"),
    ]

    @property
    def gaitsim(self) -> "GaitsimApp":
        """The app."""
        return cast("GaitsimApp", self.app)

    def command_line(self) -> str:
        """Return the command line that does the same as this screen; '' for none."""
        return ""

    def palette(self) -> Iterable[PaletteCommand]:
        """Return the commands without a key that work now."""
        return ()

    async def may_leave(self) -> bool:
        """Return whether the screen may be closed, after asking or saving where necessary.

        It is awaited in a worker, so `await self.app.push_screen_wait(…)` works in it.
        """
        return True

    async def in_thread(self, work: Callable[..., T], *arguments: object) -> T:
        """Call a function in a thread; end the worker that awaits it if the screen is left."""
        result = await asyncio.to_thread(work, *arguments)
        if not self.app.is_running or self not in self.app.screen_stack:
            raise asyncio.CancelledError
        return result

    def is_busy(self, group: str) -> bool:
        """Return whether a worker of a group runs."""
        return any(worker.group == group and worker.is_running for worker in self.workers)

    def action_back(self) -> None:
        """Go back to the screen before this one."""
        self.gaitsim.leave(self)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether an action works now."""
        if action == "back":
            return len(self.app.screen_stack) > 1
        return super().check_action(action, parameters)
