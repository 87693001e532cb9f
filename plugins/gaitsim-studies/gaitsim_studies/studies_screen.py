"""Studies and comparisons over repeats: start, follow, stop and continue them; their results."""

import shlex
from pathlib import Path

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widget import Widget
from textual.widgets import DataTable, Static

from gaitsim.plugin import STUDIES, GaitsimError, entries
from gaitsim.plugin.pictures import ago, visible, visible_lines
from gaitsim.plugin.runs import EXPERIMENT, command
from gaitsim.screen import (
    BAR,
    FileTable,
    GaitScreen,
    OpenTable,
    Task,
    TaskChanged,
    bindings,
    clip,
    clip_name,
    copy_paths,
    progress_bar,
)
from gaitsim_studies.results import (
    DEFAULT_FOLDERS,
    REPORT,
    Section,
    StudyFolder,
    list_folders,
    sections,
)
from gaitsim_studies.study_dialog import COMPARISON, SWEEP, StudyDialog

EVERY = 1.0  # seconds between two scans of the folders
STATES = {
    "running": ("● running", "success"),
    "stopped": ("■ stopped", "warning"),
    "finished": ("✓ finished", "primary"),
    "damaged": ("✗ damaged", "error"),
}
COLUMNS = {"kind": 10, "state": 10, "progress": BAR + 6, "changed": 8}  # the name takes the rest
LEAST = 12  # minimum columns of a name
WIDEST = 40  # columns of a cell
TALLEST = 14  # rows of a table before it scrolls


class Studies(GaitScreen):
    """The folders of studies and comparisons, with their progress."""

    SUB_TITLE = "studies and comparisons"
    HELP_TEXT = """
One run says little about an option. Studies and comparisons repeat experiments from different
random populations.

- A **study** sweeps options over ranges: a table of all combinations, surfaces, and the
  cheapest combination that reaches a target. A stopped study keeps its finished cells and can be
  **continued**.
- A **comparison** compares experiments: medians with intervals, tests of each pair with effect
  sizes, how often and how soon a target is reached. A stopped comparison keeps its finished
  repeats: starting it again continues it.

Both run in the background. **Open** shows tables, intervals, tests and files. **Verify** repeats a
part of either and compares every bit.
"""
    BINDINGS = bindings("studies")
    DEFAULT_CSS = """
    Studies {
        & DataTable { height: 1fr; }
        & #no-studies { height: 1fr; padding: 1 2; color: $text-muted; }
        & #study-about { height: auto; max-height: 40%; padding: 0 1; background: $surface; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self._folders: list[StudyFolder] = []

    def content(self) -> ComposeResult:
        yield OpenTable(id="studies")
        yield Static("Looking for studies …", id="no-studies")
        yield Static(id="study-about")

    def on_mount(self) -> None:
        """Scan the folders, now and every second."""
        table = self.query_one(DataTable)
        for name, width in COLUMNS.items():
            table.add_column(name, key=name, width=width)
        table.add_column("name", key="name", width=self._name_width)
        table.display = False
        self.look()
        self.set_interval(EVERY, self._look_again)

    def _look_again(self) -> None:
        if self.is_active and not self.is_busy("look"):
            self.look()

    @work(group="look")
    async def look(self) -> None:
        """Scan the folders and show them."""
        message = (
            "This folder has no studies/ or comparisons/ yet.\n\n"
            "Press n to sweep options, c to compare experiments; or in a terminal:\n"
            "gaitsim study millipede-operators"
        )
        try:
            self._folders = await self.in_thread(list_folders)
        except GaitsimError as error:
            self._folders, message = [], visible_lines(str(error))
        self.query_one("#no-studies", Static).update(Text(message))
        self._fill()

    def on_task_changed(self, event: TaskChanged) -> None:
        """Show the progress of a task; rescan the folders when it ends."""
        self._fill()
        if not event.task.running:
            self._look_again()

    def _fill(self) -> None:
        table, chosen = self.query_one(DataTable), self._chosen_path()
        rows = {str(one.path): self._row(one) for one in self._folders}
        if [str(key.value) for key in table.rows] != [*rows]:
            table.clear()
            for key, cells in rows.items():
                table.add_row(*cells, key=key)
            if chosen in rows:
                table.move_cursor(row=[*rows].index(chosen))
        else:
            for key, cells in rows.items():
                for name, cell in zip((*COLUMNS, "name"), cells, strict=True):
                    if table.get_cell(key, name) != cell:
                        table.update_cell(key, name, cell)
        table.display = bool(rows)
        self.query_one("#no-studies").display = not rows
        if rows and self.focused is None:
            table.focus()
        self._show()

    @property
    def _name_width(self) -> int:
        rest = sum(COLUMNS.values()) + 2 * (len(COLUMNS) + 1) + 1
        return max(self.size.width - rest, LEAST)

    def on_resize(self) -> None:
        column = self.query_one(DataTable).ordered_columns[-1]
        if column.width != self._name_width:
            column.width = self._name_width
            self._fill()
            self.query_one(DataTable).refresh(layout=True)

    def _row(self, one: StudyFolder) -> tuple[Text, ...]:
        state, colour = STATES[one.state]
        task = self._latest_task(one.path)
        part = one.done / one.total if one.total else (task.share if task else None)
        part = 1.0 if one.state == "finished" else part
        return (
            Text(one.kind),
            Text(state, f"${colour}"),
            Text("" if part is None else progress_bar(part)),
            Text(ago(self.gaitsim.clock() - one.changed)),
            Text(clip_name(one.path.name, self._name_width)),
        )

    @on(DataTable.RowHighlighted)
    def _show(self) -> None:
        """Show details of the highlighted folder."""
        one = self._chosen()
        panel = self.query_one("#study-about", Static)
        panel.display = one is not None
        if one is None:
            self.refresh_bindings()
            return
        task = self._latest_task(one.path)
        lines = [Text(visible(str(one.path)), "bold")]
        if one.description:
            lines.append(Text(visible(one.description)))
        if one.total is not None:
            lines.append(Text(f"{one.done:,} of {one.total:,} cells finished"))
        if one.problem is not None:
            lines.append(Text(visible_lines(str(one.problem)), "$error"))
        elif task is not None and task.running:
            lines.append(Text(task.progress or "Preparing", "dim"))
        elif one.kind == "comparison" and one.state == "stopped":
            lines.append(Text("The comparison was stopped; start it again to continue it.", "dim"))
        lines.append(Text(f"Command: {visible(self.command_line())}", "$secondary"))
        panel.update(Text("\n").join(lines))
        self.refresh_bindings()

    def _chosen(self) -> StudyFolder | None:
        row = self.query_one(DataTable).cursor_row
        return self._folders[row] if 0 <= row < len(self._folders) else None

    def _chosen_path(self) -> str:
        one = self._chosen()
        return "" if one is None else str(one.path)

    def _latest_task(self, folder: Path) -> Task | None:
        """Return the app's latest task in a folder, running or finished."""
        found = [
            task
            for task in self.gaitsim.tasks.all
            if task.arguments[0] in ("study", "compare") and str(folder) in task.arguments
        ]
        return found[-1] if found else None  # fmt: skip

    @on(DataTable.RowSelected)
    def action_open(self) -> None:
        one = self._chosen()
        if one is not None and self.is_active:  # a double click arrives twice
            self.app.push_screen(StudyResults(one.path, self.command_line()))

    @work(group="ask")
    async def action_sweep(self) -> None:
        await self._ask_and_start(StudyDialog(SWEEP, {"study": next(iter(entries(STUDIES)), "")}))

    @work(group="ask")
    async def action_compare(self) -> None:
        await self._ask_and_start(StudyDialog(COMPARISON))

    async def _ask_and_start(self, dialog: StudyDialog) -> None:
        arguments = await self.app.push_screen_wait(dialog)
        if arguments:
            self.gaitsim.start_task(arguments)

    def action_continue(self) -> None:
        one = self._chosen()
        if one is not None:
            self.gaitsim.start_task(("study", str(one.path)))

    def action_stop(self) -> None:
        task = self._latest_task(Path(self._chosen_path()))
        if task is not None:
            self.gaitsim.tasks.stop(task)

    @property
    def to_verify(self) -> Path | None:
        one = self._chosen()
        if one is None or one.state == "running":
            return None
        return one.path if one.done or one.state == "finished" else None

    def command_line(self) -> str:
        one = self._chosen() if self.is_mounted else None
        if one is None:
            return shlex.join(["ls", *map(str, DEFAULT_FOLDERS)])
        if one.kind == "study":
            return command("study", one.path)
        task = self._latest_task(one.path)
        return task.command if task else shlex.join(["cat", str(one.path / "report.md")])

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        one = self._chosen() if self.is_mounted else None
        task = self._latest_task(one.path) if one is not None else None
        match action:
            case "on_screen" if parameters == ("studies",):
                return False
            case "open":
                return one is not None
            case "continue":
                return one is not None and one.kind == "study" and one.state == "stopped"
            case "stop":
                return task is not None and task.running
        return super().check_action(action, parameters)


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

    def content(self) -> ComposeResult:
        yield VerticalScroll(Static("reading …", classes="paragraph"), can_focus=True)

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

    @property
    def to_verify(self) -> Path | None:
        return self._folder if (self._folder / REPORT).exists() else None

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


def ask_comparison(screen: GaitScreen) -> None:
    """Ask for a comparison of the experiments of a screen's runs, and start it."""
    if screen.choice is None:
        return
    runs = (screen.choice.run, *screen.choice.others)
    experiments = shlex.join(str(run / EXPERIMENT) for run in runs)

    def start(arguments: tuple[str, ...] | None) -> None:
        if arguments:
            screen.gaitsim.start_task(arguments)
            screen.app.push_screen(Studies())

    screen.app.push_screen(StudyDialog(COMPARISON, {"experiments": experiments}), start)
