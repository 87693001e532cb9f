"""Commands in the background, and the files that they export from a run."""

import shlex
from pathlib import Path

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import DataTable, Static

from gaitsim.render.terminal.text import duration, visible
from gaitsim.storage.files.folder import EXPORTS
from gaitsim.tui.formatting import clip, percentage
from gaitsim.tui.keys import bindings
from gaitsim.tui.opener import copy_paths, open_or_copy
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.tasks import Task, TaskChanged
from gaitsim.tui.widgets.lists import FileTable, OpenTable

GLYPHS = {"running": "●", "done": "✓", "failed": "✗", "stopped": "■"}
BAR = 10  # cells of a progress bar
LONG = 500  # characters shown of a command, which may contain a challenge code
COLUMNS = ("state", "progress", "time", "command")


class TaskList(GaitScreen):
    """The tasks and the output of the highlighted one."""

    SUB_TITLE = "background tasks"
    HELP_TEXT = """
Exports (gait files, plots, videos, analyses) and verifications run in the background; the last
column shows their commands. Below the list are the command of the highlighted task and its output:
the files that it wrote, what differs, or why it failed.

Enter, or a click on the highlighted task, **opens** its file with your system's default program.
Without one, such as over SSH, its path is copied; in a browser, the file is downloaded. A task
with several files opens their list.
"""
    BINDINGS = bindings("tasks")

    def content(self) -> ComposeResult:
        yield OpenTable(id="tasks")
        with VerticalScroll(id="task-output"):
            yield Static(id="task-text")

    def on_mount(self) -> None:
        """Fill the table and start updating its times."""
        table = self.query_one(DataTable)
        for name, width in zip(COLUMNS, (10, BAR + 6, 11, None), strict=True):
            table.add_column(name, key=name, width=width)
        self._fill()
        table.move_cursor(row=len(self.gaitsim.tasks.all) - 1)
        self.set_interval(1, self._tick)

    def command_line(self) -> str:
        task = self._chosen()
        return task.command if task else ""

    def on_task_changed(self, event: TaskChanged) -> None:
        """Update the task's row."""
        task = event.task
        if task not in self.gaitsim.tasks.all:  # already cleared from the list
            return
        self._draw(task)
        if task is self._chosen():
            self._show(task)
        self.refresh_bindings()

    def _fill(self) -> None:
        table = self.query_one(DataTable)
        at = table.cursor_row
        table.clear()
        for task in self.gaitsim.tasks.all:
            table.add_row(*_row(task), key=str(id(task)))
        table.move_cursor(row=at)

    def _tick(self) -> None:
        for task in self.gaitsim.tasks.all:
            if task.running:
                self._draw(task)
                if task is self._chosen():
                    self._show(task)

    def _draw(self, task: Task) -> None:
        table = self.query_one(DataTable)
        if str(id(task)) not in table.rows:  # a new task
            self._fill()
        for name, cell in zip(COLUMNS, _row(task), strict=True):
            if table.get_cell(str(id(task)), name) != cell:
                table.update_cell(str(id(task)), name, cell)

    def _chosen(self) -> Task | None:
        tables, tasks = self.query(DataTable), self.gaitsim.tasks.all
        row = tables.first().cursor_row if tables else -1  # -1 while the screen is composed
        return tasks[row] if 0 <= row < len(tasks) else None

    def on_data_table_row_highlighted(self) -> None:
        task = self._chosen()
        if task is not None:
            self._show(task)
        self.refresh_bindings()

    def _show(self, task: Task) -> None:
        lines = [Text(f"$ {clip(task.command, LONG)}", style="$secondary")]
        lines += map(Text, task.output)
        lines += [Text(line, style="$warning") for line in task.notices]
        silent = not (task.output or task.notices)
        if task.error is not None or (task.state == "failed" and silent):
            lines.append(Text(task.message, style="$error"))
        if task.files:
            lines.append(Text(f"enter: {'open' if len(task.files) == 1 else 'list files'}", "dim"))
            lines += [Text(visible(str(file.absolute()))) for file in task.files]
        if task.running:
            lines.append(Text(f"{task.progress or 'Working'} · {duration(task.seconds)}", "dim"))
        text = Text("\n").join(lines)
        self.query_one("#task-text", Static).update(text)

    def action_stop(self) -> None:
        task = self._chosen()
        if task is not None:
            self.gaitsim.tasks.stop(task)

    def action_clear(self) -> None:
        self.gaitsim.tasks.clear()
        self._fill()
        self.query_one("#task-text", Static).update("")
        self.refresh_bindings()

    def action_again(self) -> None:
        task = self._chosen()
        if task is not None:
            self.gaitsim.start_task(task.arguments)
            self._fill()
            self.query_one(DataTable).move_cursor(row=len(self.gaitsim.tasks.all) - 1)

    @on(DataTable.RowSelected)
    @work(group="open", exclusive=True)
    async def open(self) -> None:
        """Open the task's file, or the list if there are several."""
        task = self._chosen()
        if task is None or not task.files:
            return
        folder = task.files[0].parent
        if len(task.files) > 1 and folder.name == EXPORTS:
            self.show_screen("tasks.Files", folder.parent)
        else:
            await open_or_copy(self.app, task.files[0], trusted=True)

    def action_copy_result(self) -> None:
        """Copy the paths of the files that the task wrote, one per line."""
        task = self._chosen()
        if task is not None:
            copy_paths(self.app, task.files)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        task = self._chosen() if self.is_mounted else None
        if action in ("open", "copy_result"):
            return task is not None and bool(task.files)
        if action in ("stop", "again"):
            return task is not None and task.running == (action == "stop")
        if action == "clear":
            return any(not task.running for task in self.gaitsim.tasks.all)
        return super().check_action(action, parameters)


def _row(task: Task) -> tuple[Text, ...]:
    glyph = f"{GLYPHS[task.state]} {task.state}"
    share = 1.0 if task.state == "done" else task.share
    bar = "" if share is None else progress_bar(share)
    cells = (glyph, bar, duration(task.seconds), task.command)
    return tuple(Text(cell, no_wrap=True) for cell in cells)


def progress_bar(share: float) -> str:
    """Return a bar for a share from 0 to 1, followed by the percentage."""
    full = round(share * BAR)
    return f"{'━' * full}{'╌' * (BAR - full)} {percentage(share)}"


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

    def content(self) -> ComposeResult:
        yield FileTable(id="files")
        yield Static(id="no-files")
        yield Static(id="file-path", classes="command")

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
