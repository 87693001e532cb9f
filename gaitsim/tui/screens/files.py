"""The files exported from a run."""

import shlex
from pathlib import Path

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.widgets import DataTable, Static

from gaitsim.render.terminal.text import visible
from gaitsim.runs.files.folder import EXPORTS
from gaitsim.tui.actions import bindings
from gaitsim.tui.opener import copy_paths
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.tasks import TaskChanged
from gaitsim.tui.widgets.file_table import FileTable
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header


class Files(GaitScreen):
    """A table of the files in a run's folder `exports`."""

    HELP_TEXT = """
The gait files, plots, videos and analyses exported from this run, the latest first.

Enter, or a click on the highlighted file, **opens** it with your system's default program. Without
one, such as over SSH, its path is copied; in a browser, the file is downloaded.
"""
    BINDINGS = bindings("files")
    DEFAULT_CSS = """
    Files {
        & DataTable { height: 1fr; }
        & #no-files { height: 1fr; padding: 1 2; color: $text-muted; }
        & #file-path { height: auto; padding: 0 1; background: $surface; }
    }
    """

    def __init__(self, run: Path) -> None:
        super().__init__()
        self.run = run

    def compose(self) -> ComposeResult:
        yield Header()
        yield FileTable(id="files")
        yield Static(id="no-files")
        yield Static(id="file-path", classes="command")
        yield Footer()

    def on_mount(self) -> None:
        """List the files."""
        self.sub_title = f"files of {visible(str(self.run))}"
        none = f"{visible(str(self.run))} has no exports yet. Press e to export files."
        self.query_one("#no-files", Static).update(Text(none))
        self._list()

    def on_screen_resume(self) -> None:
        self._list()

    def on_task_changed(self, event: TaskChanged) -> None:
        """List the files that a task has written."""
        if not event.task.running:
            self._list()

    def _list(self) -> None:
        table = self.query_one(FileTable)
        table.list_folder(self.run / EXPORTS, self.gaitsim.clock())
        table.display = bool(table.row_count)
        self.query_one("#no-files").display = not table.row_count
        if table.row_count and self.focused is None:
            table.focus()
        self._show_path()

    @on(DataTable.RowHighlighted)
    def _show_path(self) -> None:
        chosen = self._chosen()
        path = visible(str(chosen.absolute())) if chosen else ""
        self.query_one("#file-path", Static).update(Text(path))
        self.refresh_bindings()

    def _chosen(self) -> Path | None:
        return self.query_one(FileTable).chosen

    @property
    def choice(self) -> RunChoice:
        return RunChoice(self.run)

    def command_line(self) -> str:
        return shlex.join(["ls", "-lt", str(self.run / EXPORTS)])

    def action_copy_path(self) -> None:
        chosen = self._chosen()
        if chosen is not None:
            copy_paths(self.app, [chosen])

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "copy_path":
            return self.is_mounted and self._chosen() is not None
        return super().check_action(action, parameters)
