"""Choose the file of a robot or an experiment; the list says what each file is."""

import asyncio
import os
import re
import stat
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Input, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.registry import FILES, entries
from gaitsim.render.terminal.text import visible
from gaitsim.tui.formatting import file_size
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog

LISTED = 500  # maximum number of entries shown
SCANNED = 100_000  # maximum number of entries read from a folder
LARGEST = 4_000_000  # bytes of a file that are read
_ROBOT = re.compile(rb"<(robot|mujoco)[\s>]")
_JOINT = re.compile(rb"<joint[\s/>]")
_EXPERIMENT = re.compile(rb"^\s*\[organism\]|^\s*organism\s*=", re.MULTILINE)


class FoundFile(NamedTuple):
    """An entry of a folder: its name, and whether it is a folder."""

    name: str
    is_folder: bool


def list_folder(folder: Path, begin: str = "") -> list[FoundFile]:
    """Return the folders and files that may be robots or experiments, folders first.

    Hidden entries are skipped, unless `begin` starts with a dot.

    Args:
        folder: folder to list.
        begin: beginning of the names, in any case.
    """
    found = []
    suffixes = {".toml", *(f".{suffix}" for suffix in entries(FILES))}
    try:
        with os.scandir(folder) as scan:
            for entry in islice(scan, SCANNED):
                name = entry.name
                if not name.casefold().startswith(begin.casefold()):
                    continue
                if name.startswith(".") and not begin.startswith("."):
                    continue
                if _is(entry, stat.S_ISDIR):
                    found.append(FoundFile(name, True))
                elif Path(name).suffix.casefold() in suffixes and _is(entry, stat.S_ISREG):
                    found.append(FoundFile(name, False))
    except OSError:  # it does not exist, or cannot be read
        return []
    return sorted(found, key=lambda one: (not one.is_folder, one.name.casefold()))[:LISTED]


def _is(entry: "os.DirEntry[str]", kind: Callable[[int], bool]) -> bool:
    try:
        return kind(entry.stat().st_mode)
    except OSError:
        return False


def describe_file(path: Path) -> str:
    """Return what a file is by its content: 'robot (URDF), 18 joints'; '' for other files."""
    try:
        # A pipe that replaced the file would otherwise block.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(number, "rb") as file:
            if not stat.S_ISREG(os.fstat(number).st_mode):
                return ""
            data = file.read(LARGEST)
    except (OSError, ValueError):
        return "cannot be read"
    if path.suffix.casefold() == ".toml":
        return "experiment" if _EXPERIMENT.search(data) else ""
    root = _ROBOT.search(data)
    if root is None:
        return ""
    joints = len(_JOINT.findall(data))
    language = "URDF" if root[1] == b"robot" else "MJCF"
    return f"robot ({language}), {joints} joint{'s' * (joints != 1)}"


class ChooseFile(Dialog[str | None]):
    """Ask for the file of a robot or an experiment; return its path, or None.

    Args:
        start: folder to list first.
    """

    AUTO_FOCUS = "#path"
    BINDINGS = bindings("choose-file")
    DEFAULT_CSS = """
    ChooseFile {
        & #path { background: $panel; padding: 0 1; }
        & OptionList { height: 1fr; border: none; padding: 0; background: $surface; }
    }
    """

    def __init__(self, start: Path = Path()) -> None:
        super().__init__()
        self._start = f"{start}/" if start != Path() else "./"
        self._found: list[FoundFile] = []

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "A robot (URDF, MJCF) or an experiment (TOML)"
            box.border_subtitle = "enter: open · tab: complete · ↑↓: choose · esc: cancel"
            yield Input(self._start, compact=True, select_on_focus=False, id="path")
            yield OptionList(id="entries")
            yield Static(id="file-problem", classes="problem")

    @property
    def _typed(self) -> tuple[Path, str]:
        """The folder of the typed path, and the beginning of a name in it."""
        folder, begin = os.path.split(self.query_one("#path", Input).value)
        return Path(folder or ".").expanduser(), begin

    @on(Input.Changed)
    def _changed(self, event: Input.Changed) -> None:
        if event.value.startswith((".//", "./~")):  # a whole path was typed after the ./
            event.input.value = event.value.removeprefix("./")
            return
        self.query_one("#file-problem", Static).update("")
        self._list()

    @work(group="list", exclusive=True)
    async def _list(self) -> None:
        """List the folder, then say what each file is."""
        folder, begin = self._typed
        menu = self.query_one(OptionList)
        found = await asyncio.to_thread(list_folder, folder, begin)
        self._found = found
        menu.clear_options()
        menu.add_options(Option(_line(one, "")) for one in found)
        menu.highlighted = 0 if found else None
        for index, one in enumerate(found):
            if not one.is_folder:
                about = await asyncio.to_thread(_about, folder / one.name)
                if self._found is found and about:
                    menu.replace_option_prompt_at_index(index, _line(one, about))

    def action_complete(self) -> None:
        """Complete the typed path with the highlighted entry."""
        if (one := self._highlighted) is not None:
            self._complete(one)

    @property
    def _highlighted(self) -> FoundFile | None:
        at = self.query_one(OptionList).highlighted
        return self._found[at] if at is not None and at < len(self._found) else None

    def _complete(self, one: FoundFile) -> None:
        field = self.query_one("#path", Input)
        folder = os.path.split(field.value)[0]
        field.value = os.path.join(folder, one.name) + "/" * one.is_folder  # noqa: PTH118 (keeps ./)
        field.cursor_position = len(field.value)
        field.focus()

    @on(Input.Submitted)
    @on(OptionList.OptionSelected)
    def _open(self) -> None:
        """Open the highlighted folder, or return the highlighted or typed file."""
        folder, begin = self._typed
        one = self._highlighted
        if one is not None and one.is_folder:
            self._complete(one)
            return
        path = folder / (one.name if one is not None else begin)
        if path.is_file():
            text = str(path)
            # A path with a folder is not mistaken for a preset's name.
            self.dismiss(text if path.name != text else f"./{text}")
        else:
            wrong = "neither a robot nor an experiment in" if path.is_dir() else "file not found:"
            problem = f"✗ {wrong} {visible(str(path))}"
            self.query_one("#file-problem", Static).update(Text(problem))

    def action_move(self, by: int) -> None:
        """Move the cursor of the list, from the field."""
        menu = self.query_one(OptionList)
        (menu.action_cursor_down if by > 0 else menu.action_cursor_up)()


def _about(path: Path) -> str:
    about = describe_file(path)
    try:
        return about and f"{about} · {file_size(path.stat().st_size)}"
    except OSError:
        return about


def _line(one: FoundFile, about: str) -> Text:
    name = visible(one.name)
    if one.is_folder:
        return Text(f"{name}/", "$secondary", no_wrap=True, overflow="ellipsis")
    return Text.assemble((f"{name}  ", "bold" if about else ""), (about, "$primary"))
