"""What all screens share."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import ClassVar, NamedTuple, Protocol, cast

from textual.binding import Binding, BindingType
from textual.screen import Screen

from gaitsim.errors import GaitsimError
from gaitsim.tui.tasks import Tasks


class PaletteCommand(NamedTuple):
    """What a screen offers in the command palette beside its keys.

    Attributes:
        title: what it does.
        help: more about it, on one line.
        do: does it.
    """

    title: str
    help: str
    do: Callable[[], object]


class Navigator(Protocol):
    """The app, as screens see it: the way to other screens, and what all of them share.

    Attributes:
        folder: where runs are.
        clock: the time, in seconds since 1970.
        tasks: the commands in the background.
    """

    folder: Path
    clock: Callable[[], float]
    tasks: Tasks

    def open_run(self, run: Path, *, go: bool = False) -> None: ...
    def open_new(self, experiment: str | None = None) -> None: ...
    def open_replay(
        self, run: Path, generation: int | None = None, beside: Path | None = None
    ) -> None: ...
    def open_compare(self, runs: list[Path]) -> None: ...
    def open_plugins(self) -> None: ...
    def open_export(self, run: Path) -> None: ...
    def begin_task(self, arguments: Sequence[str]) -> None: ...
    def leave(self, screen: Screen[None]) -> None: ...
    def tell(self, error: GaitsimError) -> None: ...
    def palette(self) -> Iterable[PaletteCommand]: ...


class GaitScreen(Screen[None]):
    """A screen with a help text; its keys have ids, so that users can choose others.

    A binding that cannot work now is to be refused by `check_action`: then neither the footer
    nor the command palette offers it.

    Attributes:
        HELP_TEXT: what the screen is for and how it is used, in Markdown.
    """

    HELP_TEXT: ClassVar[str] = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", id="screen.back", tooltip="To the screen before this"),
    ]

    @property
    def gaitsim(self) -> Navigator:
        """The app."""
        return cast(Navigator, self.app)

    def command_line(self) -> str:
        """The command that does, or shows, what this screen does; '' where there is none."""
        return ""

    def palette(self) -> Iterable[PaletteCommand]:
        """What can be done here now that has no key."""
        return ()

    async def may_leave(self) -> bool:
        """Whether the screen may be left, or the app be ended; it may ask, and save, before.

        It is awaited in a worker, so `await self.app.push_screen_wait(…)` works in it.
        """
        return True

    def action_back(self) -> None:
        """Go back to the screen before this one."""
        self.gaitsim.leave(self)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether an action can be done now."""
        if action == "back":
            return len(self.app.screen_stack) > 1
        return super().check_action(action, parameters)
