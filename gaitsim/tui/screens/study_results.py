"""The results of a study or a comparison: tables with intervals and tests and its files."""

from pathlib import Path

from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widget import Widget
from textual.widgets import DataTable, Static

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.study.results import Section, sections
from gaitsim.tui.actions import bindings
from gaitsim.tui.formatting import clip
from gaitsim.tui.opener import copy_paths
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.tasks import TaskChanged
from gaitsim.tui.widgets.file_table import FileTable
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header

WIDEST = 40  # columns of a cell
TALLEST = 14  # rows of a table before it scrolls


class StudyResults(GaitScreen):
    """The report, tables and files in a folder.

    Args:
        folder: folder of a study or a comparison.
        line: command line that writes or shows it.
    """

    HELP_TEXT = """
The results of a study or a comparison: medians and means with 95 % intervals, quartiles, tests of
each pair with effect sizes, successes, and a paragraph for the methods section of a paper.

Tab moves between tables; the arrow keys scroll a table that is wider than the screen. The files
(report, table and figures) are listed at the end: Enter or a click on the highlighted file
**opens** it with your system's default program.
"""
    BINDINGS = bindings("results")
    DEFAULT_CSS = """
    StudyResults {
        & VerticalScroll { height: 1fr; }
        & .heading { text-style: bold; color: $primary; padding: 1 1 0 1; }
        & .paragraph { padding: 0 1; height: auto; color: $foreground 80%; }
        & DataTable { height: auto; width: 1fr; }
        & DataTable > .datatable--fixed { background: $background; color: $text-muted; }
    }
    """

    def __init__(self, folder: Path, line: str) -> None:
        super().__init__()
        self._folder, self._line = folder, line

    def compose(self) -> ComposeResult:
        yield Header()
        yield VerticalScroll(Static("reading …", classes="paragraph"), can_focus=True)
        yield Footer()

    def on_mount(self) -> None:
        self.sub_title = visible(str(self._folder))
        self.look()

    def on_task_changed(self, event: TaskChanged) -> None:
        """Re-read the folder when its task ends."""
        if not event.task.running and str(self._folder) in event.task.arguments:
            self.look()

    @work(group="look", exclusive=True)
    async def look(self) -> None:
        """Read the folder and show its contents."""
        parts: list[Widget] = []
        try:
            found = await self.in_thread(sections, self._folder)
        except GaitsimError as error:
            found = []
            parts.append(Static(Text(visible_lines(str(error))), classes="paragraph problem"))
        for section in found:
            parts += _widgets(section)
        if not parts:
            text = "There is no result yet: the report is written at the end."
            parts.append(Static(text, classes="paragraph"))
        parts.append(Static("Files", classes="heading"))
        files = FileTable(id="study-files")
        parts.append(files)
        place = self.query_one(VerticalScroll)
        async with self.batch():
            await place.remove_children()
            await place.mount_all(parts)
            files.list_folder(self._folder, self.gaitsim.clock())
        self.refresh_bindings()

    def _file(self) -> Path | None:
        """Return the highlighted file, while its table has the focus."""
        return next((table.chosen for table in self.query(FileTable) if table.has_focus), None)

    def action_files(self) -> None:
        self.query_one(FileTable).focus()

    def action_copy_path(self) -> None:
        file = self._file()
        if file is not None:
            copy_paths(self.app, [file])

    def command_line(self) -> str:
        return self._line

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "copy_path":
            return self.is_mounted and self._file() is not None
        if action == "files":
            return any(table.row_count for table in self.query(FileTable))
        return super().check_action(action, parameters)


def _widgets(section: Section) -> list[Widget]:
    """Return a section's heading, table and texts."""
    found: list[Widget] = [Static(Text(visible(section.title)), classes="heading")]
    if section.columns:
        table: DataTable[Text] = DataTable(show_cursor=False, fixed_columns=1)
        table.styles.max_height = TALLEST
        for number, column in enumerate(section.columns):
            cells = [column, *(row[number] for row in section.rows)]
            width = max(len(clip(cell, WIDEST)) for cell in cells)
            table.add_column(Text(visible(column)), width=max(width, 1))
        for row in section.rows:
            table.add_row(*(Text(clip(cell, WIDEST)) for cell in row))
        found.append(table)
    texts = [*section.texts, *([f"$ {section.command}"] if section.command else [])]
    found += [Static(Text(visible_lines(text)), classes="paragraph") for text in texts]
    return found
