"""The base class of all screens."""

import asyncio
import json
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar, cast

from textual import command, work
from textual.app import ComposeResult
from textual.binding import Binding
from textual.dom import DOMNode
from textual.events import Key
from textual.filter import LineFilter
from textual.screen import ModalScreen, Screen
from textual.widgets import Button

from gaitsim.errors import GaitsimError
from gaitsim.tui.keys import NAMED, PREFIX, add_package_actions, bindings
from gaitsim.tui.shell import Shell
from gaitsim.tui.terminal_output import ContrastFilter
from gaitsim.tui.themes import is_ours
from gaitsim.tui.widgets.footer import Footer, Header

if TYPE_CHECKING:
    from gaitsim.individual import Which
    from gaitsim.storage.compare_runs import ComparedRun
    from gaitsim.storage.overview import Overview

add_package_actions()  # Textual reads the keys of a class when it is defined

T = TypeVar("T")
Result = TypeVar("Result")
NOT_NOW = "Not available now."
LONGEST = 100_000  # maximum number of characters in a command's argument


class PaletteCommand(NamedTuple):
    """A command in the palette: its title, one line of help, and the function to call."""

    title: str
    help: str
    do: Callable[[], object]


def _everywhere(app: Shell) -> Iterable[PaletteCommand]:
    """Yield the commands without keys that all screens and dialogs have."""
    for name in sorted(app.available_themes, key=lambda name: (not is_ours(name), name)):
        if name != app.theme and not name.startswith("ansi"):
            do = partial(app.choose_theme, name)
            yield PaletteCommand(f"Theme: {name}", "Switch to this theme and keep it", do)
    yield PaletteCommand("Screenshot", "Save this screen as SVG", app.deliver_screenshot)


class RunChoice(NamedTuple):
    """The run and the individual to which the actions of a screen apply.

    Attributes:
        run: folder of the run.
        which: individual; None is the champion.
        damage: damage of its body, in the syntax of `--damage`.
        others: folders of runs to compare with.
    """

    run: Path
    which: "Which" = None
    damage: Sequence[str] = ()
    others: Sequence[Path] = ()


class GaitScreen(Screen[None]):
    """A screen with a help text, whose keys have ids so that users can remap them.

    `check_action` disables bindings that do not apply. The footer hides them, and the command
    palette shows the reason, which `obstacle` returns.

    Attributes:
        HELP_TEXT: purpose and use of the screen, in Markdown.
    """

    HELP_TEXT: ClassVar[str] = ""
    BINDINGS = bindings("screen")

    def compose(self) -> ComposeResult:
        yield Header()
        yield from self.content()
        yield Footer()

    def content(self) -> ComposeResult:
        """Compose the screen between its title bar and its row of keys."""
        yield from ()

    @property
    def gaitsim(self) -> Shell:
        """The app."""
        return cast(Shell, self.app)

    def command_line(self) -> str:
        """Return the equivalent command line, or '' if there is none."""
        return ""

    @property
    def choice(self) -> RunChoice | None:
        """The run on the screen, and its individual."""
        return None

    @property
    def plugin(self) -> tuple[str, ...]:
        """The name of the plugin on the screen; () without one."""
        return ()

    @property
    def to_verify(self) -> Path | None:
        """The run, study or adaptation on the screen; None if it has nothing to repeat."""
        return None

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield the available commands that have no key."""
        yield PaletteCommand(
            "Verify a code", "Check the score of a pasted challenge code", self.verify_code
        )
        for action in add_package_actions():
            if not action.keys and action.show is not None:
                yield PaletteCommand(action.label, action.about, partial(action.show, self))
        yield from _everywhere(self.gaitsim)

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

    def show_screen(self, name: str, *arguments: object, **options: object) -> None:
        """Show another screen, such as 'replay.Replay', made with the arguments."""
        self.app.push_screen(_screen(name, *arguments, **options))

    @work(group="ask")
    async def ask_for_file(
        self, title: str, about: str, default: str, *command: str | Path
    ) -> None:
        """Ask for a file or folder, and start a command that writes it: `… --out FILE`."""
        out = await self.app.push_screen_wait(_screen("questions.Ask", title, default, about=about))
        if out is not None:
            self.gaitsim.start_task((*map(str, command), "--out", out), opens=not self.app.is_web)

    def open_listed(self, run: "Overview | ComparedRun | None") -> None:
        """Open a listed run, or report why it cannot be read."""
        if run is None or not self.is_active:  # a double click arrives twice
            return
        if run.problem is not None:
            self.gaitsim.show_error(run.problem)
        else:
            self.show_screen("live.Live", run.path)

    def action_replay(self) -> None:
        """Replay the individual."""
        if self.choice is not None:
            run, which, damage, _ = self.choice
            self.show_screen("replay.Replay", run, which, damage=damage)

    def action_why(self) -> None:
        """Explain the score of the individual."""
        if self.choice is not None:
            self.show_screen("why.Why", self.choice.run, self.choice.which)

    @work(group="ask")
    async def action_map(self) -> None:
        """Show the archive of the run as a map, or its front, with the cursor on the member."""
        from gaitsim.tui.screens.live_source import kept_by

        choice = self.choice
        if choice is not None:
            front = await self.in_thread(kept_by, choice.run) == "front"
            self.show_screen("front.Front" if front else "atlas.Map", choice.run, choice.which)

    def action_steer(self) -> None:
        """Steer the body of the individual, which controls it."""
        from gaitsim.individual import mark_of
        from gaitsim.steering import individual_drive
        from gaitsim.storage.files.folder import command

        if self.choice is None:
            return
        run, which, damage, _ = self.choice
        mark = mark_of(which)
        changes = {"organism.damage": [*damage]} if damage else {}
        load = partial(individual_drive, f"{run}{mark}", changes)
        options = [part for key in changes for part in ("--set", f"{key}={json.dumps([*damage])}")]
        self.show_screen("steering.Steering", load, command("steer", f"{run}{mark}", *options))

    @work(group="ask")
    async def ask_preset(self) -> None:
        """Ask for a preset, and create a run from it."""
        reference = await self.app.push_screen_wait(_screen("presets.Presets", self.gaitsim.drafts))
        if reference is not None:
            self.show_screen("new.New", reference)

    def action_on_screen(self, name: str) -> None:
        """Carry out an action that a package adds."""
        (action,) = (one for one in add_package_actions() if one.name == name)
        assert action.show is not None, "an action without a function is not added"
        action.show(self)

    # The names differ because these actions are available under different conditions.
    action_on_individual = action_on_runs = action_on_plugin = action_on_screen

    def action_files(self) -> None:
        """Show the files exported from the run."""
        if self.choice is not None:
            self.show_screen("tasks.Files", self.choice.run)

    def action_export(self) -> None:
        if self.choice is not None:
            self.ask_export(self.choice)

    @work(group="ask")
    async def ask_export(self, choice: RunChoice, menu: str = "") -> None:
        """Ask what to export from a run, for the individual, with other runs to compare.

        Args:
            choice: the run and the individual.
            menu: menu of the commands to ask for instead; see `Action.menu`.
        """
        run, which, damage, others = choice
        dialog: Any = _screen("export_dialog.ExportDialog", run, which, others, damage, menu)
        answer = await self.app.push_screen_wait(dialog)
        if answer == "files":
            self.show_screen("tasks.Files", run)
        elif answer and dialog.takes_terminal:
            self.gaitsim.run_in_terminal(answer)
        elif answer:
            self.gaitsim.start_task(answer)

    @work(group="ask")
    async def action_verify(self) -> None:
        """Repeat the run, study or adaptation and compare every bit, as a task."""
        subject = self.to_verify
        if subject is None:
            return
        about = (
            "A quick run is evolved again from its own options and compared bit by bit. Of a long "
            "run, and of studies, comparisons and adaptations, a part is repeated, or everything."
        )
        answers = {"v": "Verify", "a": "All of it"}
        choose = _screen("questions.Choose", f"Verify {subject}?", answers, about)
        answer = await self.app.push_screen_wait(choose)
        if answer is not None:
            self._verify(str(subject), *(["--all"] if answer == "a" else []))

    @work(group="ask")
    async def verify_code(self) -> None:
        """Ask for a challenge code, and verify it."""
        ask = _screen("questions.AskText", "Paste a challenge code", "", "Verify", read_code)
        code = await self.app.push_screen_wait(ask)
        if code:
            self._verify(code)

    def _verify(self, subject: str, *options: str) -> None:
        """Verify a folder, a file or a code in the background, and show its progress."""
        self.gaitsim.tasks.start(("verify", subject, *options), columns=self.size.width - 2)
        self.show_screen("tasks.TaskList")

    def action_back(self) -> None:
        """Return to the previous screen."""
        self.app.run_worker(self._leave(), group="leaving", exclusive=True)

    async def _leave(self) -> None:
        if self.is_current and len(self.app.screen_stack) > 1 and await self.may_leave():
            self.dismiss()

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
                why = self.obstacle(_name(binding))
                if why and event.key not in self.active_bindings:  # slow: checks all keys
                    self.notify(why, title=binding.description, markup=False)
                    return

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether an action is available."""
        if action == "back":
            return len(self.app.screen_stack) > 1
        if action == "verify":
            return self.is_mounted and self.to_verify is not None
        if action in ("steer", "on_individual") and not (self.is_mounted and self.choice):
            return False
        if action == "on_plugin":
            return bool(self.plugin)
        if action == "on_runs" and not (self.is_mounted and self.choice and self.choice.others):
            return False
        if self.is_mounted and self.obstacle(action):
            return False
        return super().check_action(action, parameters)


class _Overlay:
    """A screen through which the one below shows, whose text stays faint."""

    def get_line_filters(self) -> Sequence[LineFilter]:
        found: Sequence[LineFilter] = super().get_line_filters()  # type: ignore[misc]
        return [one for one in found if not isinstance(one, ContrastFilter)]


class Dialog(_Overlay, ModalScreen[Result]):
    """A dialog above a screen; the palette offers its actions and buttons."""

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield the available commands that have no key: buttons, themes and the screenshot."""
        for button in self.query(Button):
            if not button.disabled:
                label = str(button.label)
                yield PaletteCommand(label, f"The button {label}", button.press)
        yield from _everywhere(cast(Shell, self.app))


class CommandPalette(_Overlay, command.CommandPalette):
    """A palette above a screen or a dialog."""


def read_code(text: str) -> str:
    """Return the challenge code in a text, on one line.

    Raises:
        GaitsimError: the text holds no valid code, or the code is too long.
    """
    from gaitsim.sharing.challenge import Challenge

    code = Challenge.read(text).code
    if len(code) > LONGEST:
        raise GaitsimError(
            f"the code has {len(code):,} characters",
            allowed=f"at most {LONGEST:,} in this dialog",
            remedy="save it to a file and run: gaitsim verify FILE",
        )
    return code


def unavailable(screen: GaitScreen, titles: Collection[str]) -> Iterator[tuple[Binding, str]]:
    """Yield the unavailable keys of a screen with reasons, except those with one of the titles."""
    seen = {*titles}
    for node in (screen.focused or screen).ancestors_with_self:
        for binding in declared_keys(node):
            if binding.description not in seen and binding.action != "back":
                seen.add(binding.description)
                why = NAMED[binding.id or ""].why
                yield binding, screen.obstacle(_name(binding)) or why or NOT_NOW


def _name(binding: Binding) -> str:
    """Return the name of a binding's action, without arguments."""
    return binding.action.partition("(")[0]


def is_command(binding: Binding) -> bool:
    """Return whether a binding is a command, unlike arrow keys, tab and the keys of lists."""
    return bool(binding.id and binding.description) and not (binding.id or "").startswith(PREFIX)


def declared_keys(node: DOMNode) -> Iterator[Binding]:
    """Yield the commands that a widget, a screen or the app declares, available or not."""
    for kind in type(node).__mro__:
        for binding in kind.__dict__.get("BINDINGS", ()):
            if isinstance(binding, Binding) and is_command(binding):
                yield binding


def _screen(name: str, *arguments: object, **options: object) -> Screen[Any]:
    """Return a new screen, such as 'replay.Replay'.

    Its module is imported now: the first paint does not wait for it, and screens that lead to each
    other do not import each other.
    """
    module, _, kind = name.partition(".")
    made: Screen[Any] = getattr(import_module(f"gaitsim.tui.screens.{module}"), kind)(
        *arguments, **options
    )
    return made
