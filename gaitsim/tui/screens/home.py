"""Home: all runs in a folder, kept up to date."""

import asyncio
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from textual import on, work
from textual.app import ComposeResult
from textual.reactive import reactive
from textual.widgets import DataTable, Input, Static

from gaitsim.errors import GaitsimError
from gaitsim.tui.screens.base import PaletteCommand
from gaitsim.tui.screens.run_actions import RunActions
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header

if TYPE_CHECKING:
    from gaitsim.runs.growing import RunsWatcher
    from gaitsim.runs.overview import Overview
    from gaitsim.tui.widgets.run_table import RunTable

EVERY = 1.0  # seconds between two scans of the folder
ACTIONS = (
    "delete", "stop", "rename", "note", "files", "replay", "map", "why", "compare", "export",
    "filter", "laboratory", "back",
)  # fmt: skip


class Home(RunActions):
    """The table of runs, with details of the one under the cursor.

    Attributes:
        runs: runs found by the last scan; None until all have been read once.
        filter: words that a run must contain to be shown.
    """

    AUTO_FOCUS = ""  # not the filter, which would take letters; the table later
    HELP_TEXT = """
The runs in a folder, the latest first. The table follows live runs, including those started in
other terminals.

- **Open** a run to watch, continue or steer it; **new** creates one. A click on the highlighted
  run also opens it.
- **Mark** two or more runs with space, or by a click on ◇, then **compare** their curves and
  options, or **replay** two side by side. **Stop** and **delete** apply to all marked runs.
- **Export** gait files, plots, videos and analyses of a run in the background.
- **Note** attaches a note to a run, **rename** changes its name.
- **Gallery** (`B`) writes a web site of all runs in the folder.
- `v` **verifies** a run; `u` shows **studies** and comparisons over repeats.
- A click on a column's title, or `s`, sorts by that column.
- `/` filters by words in the name, plugins, state or note, such as `spider running`.
"""
    filter: reactive[str] = reactive("", init=False)
    # Whether each action is available; a change updates the footer, which is slow.
    offers: reactive[list[bool | None]] = reactive(list, init=False, bindings=True)

    def __init__(self) -> None:
        super().__init__()
        self.runs: list[Overview] | None = None
        self._watch: RunsWatcher | None = None
        self._table: RunTable | None = None
        self._problem: GaitsimError | None = None
        self._height = 0
        self._listed: list[Overview] = []  # during the first scan, the runs read so far
        self._next_part = 1  # number of runs at which the table is next updated
        self._next_count = 0.0  # time of the next count, which takes as long to draw as ten runs
        self._count = ""
        self._changes = 0  # number of changes made by this screen
        self._reading = Lock()

    def compose(self) -> ComposeResult:
        """Compose the screen; the table is mounted once runs are read."""
        yield Header()
        yield Input(placeholder="words to look for", id="filter", compact=True)
        yield Static("Looking for runs …", id="empty")
        yield Static(id="details")
        yield Footer()

    def on_mount(self) -> None:
        """Scan the folder after the first paint, as reading runs imports NumPy."""
        self.sub_title = f"{self.gaitsim.folder}/"
        self.query_one("#filter").display = False
        self.query_one("#details").display = False
        self.call_after_refresh(self.look)
        self.set_interval(EVERY, self._look_again)

    def _look_again(self) -> None:
        # Not `is_current`, which is also True for the screen directly below the top one.
        if self.is_active and not self.is_busy("look"):
            self.look()

    def on_screen_resume(self) -> None:
        if self.runs is not None:
            self._look_again()

    @work(group="look")
    async def look(self) -> None:
        """Read the changes and show them; the first scan shows runs as they are read."""
        began = self._changes
        found, problem = await self.in_thread(self._read)
        if began != self._changes or self.renaming:  # outdated: another scan follows
            return
        self._problem = problem
        self.runs = self._listed = found
        self._count = f"{len(found)} run{'s' * (len(found) != 1)}"
        self._show()

    def _read(self) -> "tuple[list[Overview], GaitsimError | None]":
        from gaitsim.runs.growing import RunsWatcher

        with self._reading:
            first = self._watch is None
            self._watch = self._watch or RunsWatcher(self.gaitsim.folder)
            try:
                return self._watch.poll(self._progress if first else None), None
            except GaitsimError as error:
                return [], error

    def _progress(self, runs: "Sequence[Overview]", total: int) -> None:
        """Show the runs read so far; called from the reading thread."""
        if not self.is_attached:
            raise asyncio.CancelledError
        now = time.monotonic()
        full = len(runs) >= self._next_part  # one run, then a screenful, then twice as many
        if full or now >= self._next_count:
            self._next_count = now + EVERY
            self._next_part = max(self.size.height, 2 * len(runs)) if full else self._next_part
            self.call_later(self._show_part, [*runs] if full else [], len(runs), total)

    def _show_part(self, runs: "list[Overview]", read: int, total: int) -> None:
        if self.runs is None:
            self._count = f"{read} of {total} runs read"
            self._listed = runs or self._listed
            self._show() if runs else self._title()

    def _show(self) -> None:
        """Show the found runs."""
        if self.runs is None and not self._listed:
            return
        from gaitsim.tui.widgets.run_table import RunTable

        if self._table is None:
            self._table = RunTable(id="runs")
            self.mount(self._table, before="#details")
            self.call_after_refresh(self._show)
            return
        self._table.show(self._listed, self.filter, self.gaitsim.clock())
        empty = self.query_one("#empty", Static)
        empty.display = not self._table.shown
        self._table.display = bool(self._table.shown)
        if empty.display:
            from gaitsim.tui.widgets.details import no_runs

            folder, colours = self.gaitsim.folder, self.app.theme_variables
            empty.update(no_runs(folder, len(self._listed), self.filter, self._problem, colours))
        elif self.focused is None:
            self.set_focus(self._table)
        self._title()
        self._details()

    def _title(self) -> None:
        """Show the number of runs, and how many are in each state that needs attention."""
        states = Counter[str](run.state for run in self._listed)
        wanted = ("running", "paused", "queued", "failed")
        counts = [f"{states[state]} {state}" for state in wanted if states[state]]
        self.sub_title = " · ".join([f"{self._count} in {self.gaitsim.folder}/", *counts])

    @on(DataTable.RowHighlighted)
    def _moved(self) -> None:
        self._details()

    def on_run_table_marked(self) -> None:
        self._details()

    def _details(self) -> None:
        """Show details of the run under the cursor, or its problem."""
        from gaitsim.tui.widgets.details import details

        run = self.current()
        panel = self.query_one("#details", Static)
        panel.display = run is not None
        if run is not None:
            width = max(1, self.size.width - 2)
            text = details(run, self.app.theme_variables, width)
            height = len(text.wrap(self.app.console, width))
            # A new layout at each move of the cursor would make it lag.
            panel.update(text, layout=height != self._height)
            self._height = height
        self.offers = [self.check_action(name, ()) for name in ACTIONS]

    def current(self) -> "Overview | None":
        return self._table.run if self._table is not None and self._table.display else None

    def marked(self) -> "list[Overview]":
        marked = self._table.marked if self._table is not None else set()
        return [run for run in self._listed if run.path in marked]

    def run_changed(self, old: Path, new: Path) -> None:
        self._changes += 1
        if self._table is not None and new != old:
            self._table.run_renamed(old, new)
        self.look()

    def on_resize(self) -> None:
        self.call_after_refresh(self._show)

    def watch_filter(self) -> None:
        self._show()

    @on(Input.Changed, "#filter")
    def _typed(self, event: Input.Changed) -> None:
        self.filter = event.value

    @on(Input.Submitted, "#filter")
    def _entered(self) -> None:
        self.set_focus(self._table)

    def action_filter(self) -> None:
        box = self.query_one("#filter", Input)
        box.display = True
        self.set_focus(box)  # not the deferred `box.focus()`: letters would act as commands

    def action_back(self) -> None:
        box = self.query_one("#filter", Input)
        box.value, box.display = "", False
        self.filter = ""
        self.set_focus(self._table)

    @property
    def run_to_verify(self) -> Path | None:
        run = self.current()
        return run.path if run and run.generation and run.problem is None else None

    def command_line(self) -> str:
        run = self.current()
        if run is None:
            return ""
        from gaitsim.runs.files.folder import (
            command,  # takes 0.25 s, so not before the first paint
        )

        return command("show", run.path)

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each preset."""
        from gaitsim.registry import EXPERIMENTS, entries

        for name in entries(EXPERIMENTS):
            yield PaletteCommand(
                f"New run: {name}",
                f"Create a run from the preset {name}",
                partial(self.show_screen, "new.New", name),
            )
        yield PaletteCommand("Steer", "Fly a body yourself with the arrow keys", self._steer)
        yield from super().palette()

    def _steer(self) -> None:
        from gaitsim.runs.files.folder import command
        from gaitsim.steering import default_drive

        self.show_screen("steering.Steering", default_drive, command("steer"))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "back":
            return bool(self.filter) or bool(self.is_mounted and self.query("#filter:focus"))
        return super().check_action(action, parameters)

    def obstacle(self, action: str) -> str:
        if action == "filter" and not self._listed:
            return "There are no runs to choose from."
        return super().obstacle(action)
