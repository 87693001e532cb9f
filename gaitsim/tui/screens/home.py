"""Home: all runs in a folder, kept up to date."""

import asyncio
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.reactive import reactive
from textual.widgets import DataTable, Header, Input, Static

from gaitsim.errors import GaitsimError
from gaitsim.tui.screens.base import GaitScreen, PaletteCommand
from gaitsim.tui.widgets.footer import Footer

if TYPE_CHECKING:
    from gaitsim.runs.overview import Overview, RunsWatcher
    from gaitsim.tui.widgets.run_table import RunTable

EVERY = 1.0  # seconds between two looks at the folder


class Home(GaitScreen):
    """The table of runs, with details of the one under the cursor.

    Attributes:
        runs: as they were found last.
        filter: words that the runs shown must have.
    """

    AUTO_FOCUS = ""  # not the filter, which takes letters: the table, once it is there
    HELP_TEXT = """
The runs in a folder, the latest first. Those that are evolved now, in another terminal too, are
followed as they go.

- **Open** a run to watch, continue or steer it; **new** assembles one.
- **Mark** two or more with space, and **compare** their curves and options, or **replay** two
  side by side.
- **Make** gait files, plots, videos and analyses of a run in the background.
- A click on a column's title, or `s`, sorts by it.
- `/` shows only runs that have all the words typed, in name, plugins or state: `spider running`.
"""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("n", "new", "New", id="home.new", tooltip="Assemble a new run"),
        Binding("r", "replay", "Replay", id="home.replay", tooltip="See champions move"),
        Binding("c", "compare", "Compare", id="home.compare", tooltip="Compare the marked runs"),
        Binding("e", "export", "Export", id="home.export", tooltip="Gait files, plots, videos, …"),
        Binding("slash", "filter", "Filter", id="home.filter", tooltip="Only runs with words"),
        Binding("d,delete", "delete", "Delete", show=False, id="home.delete", tooltip="For good"),
        Binding("p", "plugins", "Plugins", show=False, id="home.plugins", tooltip="Installed ones"),
    ]
    filter: reactive[str] = reactive("", init=False)
    # Whether each key works: the footer, which is slow, is updated only with it.
    offers: reactive[list[bool | None]] = reactive(list, init=False, bindings=True)

    def __init__(self) -> None:
        super().__init__()
        self.runs: list[Overview] | None = None
        self._watch: RunsWatcher | None = None
        self._table: RunTable | None = None
        self._problem: GaitsimError | None = None
        self._height = 0

    def compose(self) -> ComposeResult:
        """Compose the screen; the table is mounted once runs are read."""
        yield Header()
        yield Input(placeholder="words to look for", id="filter", compact=True)
        yield Static("Looking for runs …", id="empty")
        yield Static(id="details")
        yield Footer()

    def on_mount(self) -> None:
        """Look once the first paint is done: reading runs imports NumPy."""
        self.sub_title = str(self.gaitsim.folder)
        self.query_one("#filter").display = False
        self.query_one("#details").display = False
        self.call_after_refresh(self.look)
        self.set_interval(EVERY, self._look_again)

    def _look_again(self) -> None:
        # Not `is_current`, which also holds for a screen that lies right below another.
        if self.is_active and not self.is_busy("look"):
            self.look()

    def on_screen_resume(self) -> None:
        if self.runs is not None:
            self._look_again()

    @work(group="look")
    async def look(self) -> None:
        """Read what has changed, and show it."""
        self.runs, self._problem = await self.in_thread(self._read)
        self._show()

    def _read(self) -> "tuple[list[Overview], GaitsimError | None]":
        from gaitsim.runs.overview import RunsWatcher

        self._watch = self._watch or RunsWatcher(self.gaitsim.folder)
        try:
            return self._watch.look(), None
        except GaitsimError as error:
            return [], error

    def _show(self) -> None:
        """Show the runs that were found."""
        if self.runs is None:
            return
        from gaitsim.tui.widgets.run_table import RunTable

        if self._table is None:
            self._table = RunTable(id="runs")
            self.mount(self._table, before="#details")
            self.call_after_refresh(self._show)
            return
        self._table.show(self.runs, self.filter, self.gaitsim.clock())
        empty = self.query_one("#empty", Static)
        empty.display = not self._table.shown
        self._table.display = bool(self._table.shown)
        if empty.display:
            from gaitsim.tui.widgets.details import no_runs

            folder, colours = self.gaitsim.folder, self.app.theme_variables
            empty.update(no_runs(folder, len(self.runs), self.filter, self._problem, colours))
        elif self.focused is None:
            self.set_focus(self._table)
        running = sum(run.state == "running" for run in self.runs)
        count = f"{len(self.runs)} run{'s' * (len(self.runs) != 1)}"
        self.sub_title = " · ".join(
            [str(self.gaitsim.folder), count, *([f"{running} running"] if running else [])]
        )
        self._details()

    @on(DataTable.RowHighlighted)
    def _moved(self) -> None:
        self._details()

    def on_run_table_marked(self) -> None:
        self._details()

    def _details(self) -> None:
        """Show details of the run under the cursor, or its problem."""
        from gaitsim.tui.widgets.details import details

        run = self._run()
        panel = self.query_one("#details", Static)
        panel.display = run is not None
        if run is not None:
            text = details(run, self.app.theme_variables)
            height = len(text.wrap(self.app.console, max(1, self.size.width - 2)))
            # Laying the screen out anew at each move of the cursor would make it lag.
            panel.update(text, layout=height != self._height)
            self._height = height
        actions = ("delete", "replay", "compare", "export", "filter", "back")
        self.offers = [self.check_action(name, ()) for name in actions]

    def _run(self) -> "Overview | None":
        return self._table.run if self._table is not None and self._table.display else None

    def _marked(self) -> list[Path]:
        """Return the marked runs, in the order of the table."""
        marked = self._table.marked if self._table is not None else set()
        return [run.path for run in self.runs or () if run.path in marked]

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
        self.set_focus(box)  # at once: `box.focus()` waits, and letters would act as commands

    def action_back(self) -> None:
        box = self.query_one("#filter", Input)
        box.value, box.display = "", False
        self.filter = ""
        self.set_focus(self._table)

    @on(DataTable.RowSelected)
    def action_open(self) -> None:
        run = self._run()
        if run is None:
            return
        if run.problem is not None:
            self.gaitsim.tell(run.problem)
        else:
            self.gaitsim.open_run(run.path)

    def action_new(self) -> None:
        self.gaitsim.open_new()

    def action_plugins(self) -> None:
        self.gaitsim.open_plugins()

    def action_replay(self) -> None:
        run, marked = self._run(), self._marked()
        if len(marked) == 2:
            self.gaitsim.open_replay(marked[0], beside=marked[1])
        elif run is not None:
            self.gaitsim.open_replay(run.path)

    def action_compare(self) -> None:
        self.gaitsim.open_compare(self._marked())

    def action_export(self) -> None:
        run = self._run()
        if run is not None:
            self.gaitsim.open_export(run.path)

    @work(group="delete")
    async def action_delete(self) -> None:
        from gaitsim.runs.removal import delete_run
        from gaitsim.tui.screens.questions import Confirm

        run = self._run()
        if run is None:
            return
        about = f"{run.path}\nIts champions and exports go with it. This cannot be undone."
        question = Confirm(f"Delete the run {run.name}?", "Delete", about, danger=True)
        if not await self.app.push_screen_wait(question):
            return
        try:
            await asyncio.to_thread(delete_run, run.path)
        except GaitsimError as error:
            self.gaitsim.tell(error)
        self.look()

    def command_line(self) -> str:
        run = self._run()
        if run is None:
            return ""
        from gaitsim.runs.files.folder import (
            command,  # a quarter of a second: not before the first paint
        )

        return command("show", run.path)

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each preset."""
        from gaitsim.registry import EXPERIMENTS, entries

        for name in entries(EXPERIMENTS):
            yield PaletteCommand(
                f"New run: {name}",
                f"Assemble a run from the preset {name}",
                lambda name=name: self.gaitsim.open_new(name),  # type: ignore[misc]
            )

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        run = self._run() if self.is_mounted else None
        match action:
            case "back":
                return bool(self.filter) or bool(self.is_mounted and self.query("#filter:focus"))
            case "delete":
                return run is not None and run.state != "running"
            case "replay" | "export":
                return run is not None and run.generation > 0 and run.problem is None
            case "compare":
                return len(self._marked()) >= 2
            case "filter":
                return bool(self.runs)
        return super().check_action(action, parameters)
