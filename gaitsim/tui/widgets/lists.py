"""Tables and lists whose rows are opened by Enter, or by a click on the highlighted row."""

import os
import stat
from pathlib import Path
from typing import Any

from rich.text import Text
from textual import on
from textual.events import Click
from textual.widgets import DataTable, OptionList

from gaitsim.render.terminal.text import age, visible
from gaitsim.tui.formatting import file_size
from gaitsim.tui.keys import bindings
from gaitsim.tui.opener import open_or_copy


class ChoiceList(OptionList):
    """A list in which a first click highlights a row and a second one chooses it."""

    async def _on_click(self, event: Click) -> None:
        row = event.style.meta.get("option")
        if row is None or row == self.highlighted:
            await super()._on_click(event)
        elif not self.get_option_at_index(row).disabled:
            self.highlighted = row
        event.prevent_default()


class OpenTable(DataTable[Text]):
    """A table that offers Enter while the screen's action `open` is available."""

    BINDINGS = bindings("files table")

    def __init__(self, **settings: Any) -> None:
        super().__init__(cursor_type="row", **settings)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "select_cursor":
            return self.can_open()
        return super().check_action(action, parameters)

    def can_open(self) -> bool:
        """Return whether the row under the cursor can be opened."""
        return bool(self.screen.check_action("open", ()))


class FileTable(OpenTable):
    """The files in a folder, the latest first."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._files: list[Path] = []

    def on_mount(self) -> None:
        for name, width in (("age", 6), ("size", 9), ("file", None)):
            self.add_column(name, width=width)

    def list_folder(self, folder: Path, now: float) -> None:
        """Show the files in a folder, and keep the cursor on the chosen file."""
        chosen = self.chosen
        found = _files_in(folder)
        self._files = [*found]
        self.clear()
        for path, state in found.items():
            cells = (age(now - state.st_mtime), file_size(state.st_size), visible(path.name))
            self.add_row(*map(Text, cells))
        if chosen in found:
            self.move_cursor(row=self._files.index(chosen))

    @property
    def chosen(self) -> Path | None:
        """The file under the cursor."""
        return self._files[self.cursor_row] if self.cursor_row < len(self._files) else None

    def can_open(self) -> bool:
        return self.chosen is not None

    @on(DataTable.RowSelected)
    def open(self) -> None:
        if self.chosen is not None:
            opening = open_or_copy(self.app, self.chosen)
            self.screen.run_worker(opening, group="open", exclusive=True)


def _files_in(folder: Path) -> dict[Path, os.stat_result]:
    """Return the files in a folder, the latest first, without links, which may lead elsewhere."""
    try:
        paths = [] if folder.is_symlink() else [*folder.iterdir()]
        found = {path: path.lstat() for path in paths if not path.name.startswith(".")}
    except OSError:  # the folder does not exist, or is being deleted
        return {}
    files = [(path, state) for path, state in found.items() if stat.S_ISREG(state.st_mode)]
    return dict(sorted(files, key=lambda file: (-file[1].st_mtime, file[0].name)))
