"""The app without its screens: what all screens share, and the keys of vi."""

import shlex
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text
from rich.theme import Theme
from textual.app import SuspendNotSupported
from textual.binding import Keymap
from textual.containers import ScrollableContainer
from textual.dom import DOMNode
from textual.events import Key
from textual.filter import LineFilter
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import DataTable, Input, OptionList, Static
from textual.worker import WorkerFailed

from gaitsim.errors import GaitsimError
from gaitsim.tui.config import (
    THEME,
    Config,
    check_keys,
    format_problem,
    remember,
    valid_keys,
)
from gaitsim.tui.formatting import NOTIFIED, clip
from gaitsim.tui.key_queue import KeyQueue
from gaitsim.tui.keys import ACTIONS, PREFIX, bindings
from gaitsim.tui.tasks import Task, TaskChanged, Tasks
from gaitsim.tui.terminal_output import ContrastFilter, ControlCharacterFilter
from gaitsim.tui.themes import DEFAULT, THEMES, ink_styles

if TYPE_CHECKING:
    from gaitsim.tui.builder import ExperimentBuilder
    from gaitsim.tui.catalogue import Catalogue

# The movements, and the action for each in three kinds of widgets.
_MOVES = ("down", "up", "first", "last", "page_down", "page_up")
_LIST = ("cursor_down", "cursor_up", "first", "last", "page_down", "page_up")
_TABLE = ("cursor_down", "cursor_up", "scroll_top", "scroll_bottom", "page_down", "page_up")
_TEXT = ("scroll_down", "scroll_up", "scroll_home", "scroll_end", "page_down", "page_up")
_KEYS = {action.name: action.keys for action in ACTIONS["list"]}
_FILTERS = ControlCharacterFilter(), ContrastFilter()


class ViKeys(KeyQueue):
    """An app in which the keys of vi move in the focused list, table or text.

    Keys of a screen, and letters typed into a field, take precedence.
    """

    BINDINGS = bindings("list")

    def __init__(self) -> None:
        super().__init__()
        self._chosen: Keymap = {}

    def set_keymap(self, keymap: Keymap) -> None:
        super().set_keymap(keymap)
        self._chosen = keymap

    def action_vi(self, move: str) -> None:
        """Move in the widget that has the focus."""
        action = _actions(self.focused).get(move)
        if action is not None:
            getattr(self.focused, f"action_{action}")()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "vi":
            return bool(_actions(self.focused))
        return super().check_action(action, parameters)

    def on_key(self, event: Key) -> None:
        """Move in dialogs too, where the keys of an app are inactive."""
        if not self.screen.is_modal or event.key in self.screen.active_bindings:
            return
        for name, key in _KEYS.items():
            if event.key in self._chosen.get(PREFIX + name, key).split(","):
                event.prevent_default()
                self.action_vi(name.replace("-", "_"))


def _actions(widget: Widget | None) -> dict[str, str]:
    """Return a widget's actions for each movement; {} if it has none."""
    if widget is None or widget.check_consume_key("j", "j"):  # a field
        return {}
    if isinstance(widget, DataTable):
        return dict(zip(_MOVES, _TABLE, strict=True))
    if isinstance(widget, OptionList):
        return dict(zip(_MOVES, _LIST, strict=True))
    if isinstance(widget, ScrollableContainer):
        return dict(zip(_MOVES, _TEXT, strict=True))
    return {}


class Shell(ViKeys):
    """The app's terminal, settings, tasks and drafts.

    Args:
        folder: folder that holds the runs.
        config: the user's settings; None for the defaults.
        theme: name of a theme; overrides the settings.
        clock: function that returns the time in seconds since 1970.

    Attributes:
        tasks: commands in the background.
        drafts: unsaved new runs by preset, the latest last.
        catalogue: installed plugins; None until a screen has read them.
        preview: whether home shows the champion under the cursor, if there is room.
        columns: keys of the columns of the list of runs; () for the usual ones.
        sort: key to sort the runs by; see `Config.sort`.
    """

    _has_inks = False  # whether the console knows the colours of a theme

    def __init__(
        self,
        folder: Path = Path("runs"),
        *,
        config: Config | None = None,
        theme: str | None = None,
        clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__()
        self.folder = folder
        self.clock = clock
        self.tasks = Tasks(self._task_changed)
        self.drafts: dict[str, ExperimentBuilder] = {}
        self.catalogue: Catalogue | None = None
        self._config = config
        self.preview = config is None or config.preview
        self.columns, self.sort = (config.columns, config.sort) if config else ((), "")
        for ours in THEMES:
            self.register_theme(ours)
        self.theme = theme or (config.theme if config else None) or DEFAULT

    # The terminal

    @property
    def notifies_desktop(self) -> bool:
        """Whether the user wants desktop notifications."""
        return self._config is None or self._config.notify

    def get_line_filters(self) -> Sequence[LineFilter]:
        """Return the filters applied to each line before it is drawn."""
        return [*super().get_line_filters(), *_FILTERS]

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

    def show_error(self, error: GaitsimError) -> None:
        """Show an error as plain text."""
        self.notify(str(error), title="", severity="error", markup=False, timeout=10)

    def copy(self, text: str) -> None:
        """Copy a text to the clipboard, and show it."""
        self.copy_to_clipboard(text)
        self.notify(text, title="Copied", markup=False)

    def _fatal_error(self) -> None:
        """End the app after an unexpected error: save its traceback and print one message."""
        error: BaseException | None = self._exception
        if isinstance(error, WorkerFailed):  # it has no traceback of its own
            error = error.error
        with tempfile.NamedTemporaryFile(
            "w", prefix="gaitsim-", suffix=".txt", encoding="utf-8", delete=False
        ) as file:
            file.write("".join(traceback.format_exception(error)))
        self.panic(
            Text(
                f"Error: the terminal UI failed: {type(error).__name__}: {error}\n"
                f"  where:   {file.name} has the traceback\n"
                "  try:     'gaitsim tui' again. Runs in the background continue: 'gaitsim runs' "
                "lists them"
            )
        )

    # Settings

    def get_css_variables(self) -> dict[str, str]:
        """Return the variables of the theme; its colours are styles of texts too."""
        variables = super().get_css_variables()
        if self._has_inks:
            self.console.pop_theme()
        self.console.push_theme(Theme(ink_styles(variables)))
        self._has_inks = True
        return variables

    def _recolour(self, theme: object) -> None:
        """Draw the texts of all screens in the colours of a new theme."""
        for screen in self.screen_stack:
            for static in screen.query(Static):
                if isinstance(static.content, Text):
                    static.update(static.content, layout=False)
            for menu in screen.query(OptionList):
                for index, option in enumerate(menu.options):
                    menu.replace_option_prompt_at_index(index, option.prompt)

    def on_mount(self) -> None:
        """Apply the user's keys; report problems of the settings."""
        self.theme_changed_signal.subscribe(self, self._recolour)
        config = self._config
        if config is None:
            return
        self._report(config.path, [*config.problems, *check_keys(config)])
        if config.keys:
            self.set_keymap(valid_keys(config))

    def _report(self, path: Path, problems: Sequence[GaitsimError]) -> None:
        """Report the problems of the settings in one message."""
        if problems:
            lines = "\n".join(map(format_problem, problems))
            self.notify(lines, title=str(path), severity="warning", markup=False, timeout=15)

    def choose_theme(self, name: str) -> None:
        """Change the theme and store it in the settings."""
        self.theme = name
        self.remember(THEME, name)

    def remember(self, key: str, value: str | bool | list[str]) -> None:
        """Store a setting, if the user's settings are read."""
        if self._config is not None:
            try:
                remember(self._config.path, key, value)
            except GaitsimError as error:
                self.show_error(error)

    # Tasks

    def start_task(self, arguments: Sequence[str], *, opens: bool = False) -> Task:
        """Run a gaitsim command in the background; with `opens`, open the file it writes."""
        task = self.tasks.start(arguments, opens=opens, columns=self.size.width - 2)
        if not self.screen.query("#tasks"):
            title = "Running in the background; press t to see it"
            self.notify(clip(task.command, NOTIFIED), title=title, markup=False)
        return task

    def run_in_terminal(self, arguments: Sequence[str]) -> None:
        """Run a gaitsim command in the terminal, in its own process, and return afterwards."""
        before = signal.signal(signal.SIGINT, lambda *_: None)  # Ctrl-C is for the command
        try:
            with self.suspend():
                subprocess.run([sys.executable, "-m", "gaitsim", *arguments], check=False)
                input("Press Enter to return to the terminal UI. ")
        except SuspendNotSupported:
            self.show_error(
                GaitsimError(
                    "this command needs a terminal, not a browser",
                    remedy=f"run it in one: {shlex.join(['gaitsim', *arguments])}",
                )
            )
        except EOFError:
            pass
        finally:
            signal.signal(signal.SIGINT, before)

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
        line = clip(task.command, NOTIFIED)
        if task.state == "done":
            result = "\n".join(map(str, task.files)) or line
            self.notify(result, title="Done", markup=False)
        elif task.state == "failed":
            self.notify(task.message, title=line, severity="error", markup=False, timeout=10)

    async def _open_file(self, file: Path) -> None:
        from gaitsim.tui.opener import open_or_copy

        await open_or_copy(self, file, trusted=True)
