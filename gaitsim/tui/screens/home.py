"""Home: all runs in a folder, kept up to date, and actions on them."""

import asyncio
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, TypeVar

from textual import on, work
from textual.app import ComposeResult
from textual.reactive import reactive
from textual.widgets import DataTable, Input, Static

from gaitsim.choices import STEERING_PRESETS
from gaitsim.errors import GaitsimError
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen, PaletteCommand, RunChoice
from gaitsim.tui.themes import INKS

if TYPE_CHECKING:
    from gaitsim.storage.growing import RunsWatcher
    from gaitsim.storage.overview import Overview
    from gaitsim.tui.widgets.run_table import RunTable

T = TypeVar("T")
LISTED = 12  # maximum number of runs that a question names
LOOKING = "Looking for runs …"
EVERY = 1.0  # seconds between two scans of the folder
ACTIONS = (
    "delete", "stop", "rename", "note", "files", "replay", "map", "why", "compare", "export",
    "filter", "laboratory", "steer", "back",
)  # fmt: skip


class Home(GaitScreen):
    """The table of runs, with details of the one under the cursor.

    Attributes:
        renaming: whether a run is being renamed.
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
    BINDINGS = bindings("home")
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
        self.renaming = False

    def content(self) -> ComposeResult:
        """Compose the screen; the table is mounted once runs are read."""
        yield Input(placeholder="words to look for", id="filter", compact=True)
        yield Static(LOOKING, id="empty")
        yield Static(id="details")

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
            if not self._listed:  # until the scan, as a run may have been created
                self.query_one("#empty", Static).update(LOOKING)
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
        from gaitsim.storage.growing import RunsWatcher

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
            from gaitsim.tui.widgets.run_table import no_runs

            folder = self.gaitsim.folder
            empty.update(no_runs(folder, len(self._listed), self.filter, self._problem, INKS))
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
        from gaitsim.tui.widgets.run_table import details

        run = self.current()
        panel = self.query_one("#details", Static)
        panel.display = run is not None
        if run is not None:
            width = max(1, self.size.width - 2)
            assert self._table is not None, "it has the cursor"
            text = details(run, INKS, width, self._table.scale(run))
            height = len(text.wrap(self.app.console, width))
            # A new layout at each move of the cursor would make it lag.
            panel.update(text, layout=height != self._height)
            self._height = height
        self.offers = [self.check_action(name, ()) for name in ACTIONS]

    def current(self) -> "Overview | None":
        """Return the run under the cursor."""
        return self._table.run if self._table is not None and self._table.display else None

    def marked(self) -> "list[Overview]":
        """Return the marked runs, in the order of the list."""
        marked = self._table.marked if self._table is not None else set()
        return [run for run in self._listed if run.path in marked]

    def run_changed(self, old: Path, new: Path) -> None:
        """Refresh the runs after one was changed or moved."""
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
        from gaitsim.storage.files.folder import (
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
        for name in STEERING_PRESETS:
            yield PaletteCommand(
                f"Steer: {name}",
                f"Steer the body of the preset {name} yourself with the arrow keys",
                partial(self._steer, name),
            )
        yield from super().palette()

    def _steer(self, name: str) -> None:
        from gaitsim.steering import preset_drive
        from gaitsim.storage.files.folder import command

        line = command("steer", name)
        self.show_screen("steering.Steering", partial(preset_drive, name), line)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "back":
            return bool(self.filter) or bool(self.is_mounted and self.query("#filter:focus"))
        return super().check_action(action, parameters)

    # Actions on runs

    def _chosen(self) -> "list[Overview]":
        """Return the marked runs, or the one under the cursor if none is marked."""
        run = self.current()
        return self.marked() or ([run] if run is not None else [])

    @property
    def choice(self) -> RunChoice | None:
        run = self.current()
        others = [one.path for one in self.marked() if one is not run]
        return None if run is None else RunChoice(run.path, others=others)

    def obstacle(self, action: str) -> str:
        run, chosen = self.current(), self._chosen()
        needs_run = (
            *("select_cursor", "mark", "replay", "why", "export", "laboratory"),
            *("map", "note", "rename", "files", "steer"),
        )
        if action in (*needs_run, "delete", "stop") and not chosen:
            return "There is no run here; press n to create one."
        match action:
            case "delete" if all(one.evolves for one in chosen):
                return "The run is evolving; press x to stop it first."
            case "stop" if not any(one.evolves for one in chosen):
                return "The run is not evolving."
            case "rename" if run is not None and run.evolves:
                return "The run is evolving; press x to stop it first."
            case "replay" | "why" | "export" | "map" | "laboratory" | "steer" if (
                run and run.problem is not None
            ):
                return "The run cannot be read; see the reason below the list."
            case "replay" | "why" | "export" | "map" | "laboratory" | "steer" if (
                run and run.generation == 0
            ):
                return "The run has no finished generation yet; open it and let it evolve."
            case "compare" if len(self.marked()) < 2:
                return "Mark two or more runs with space first."
            case "filter" if not self._listed:
                return "There are no runs to choose from."
        return super().obstacle(action)

    @on(DataTable.RowSelected)
    def action_open(self) -> None:
        self.open_listed(self.current())

    def action_new(self) -> None:
        self.show_screen("new.New")

    def action_plugins(self) -> None:
        self.show_screen("plugins.Plugins")

    def action_replay(self) -> None:
        """Replay the champion, or those of two marked runs side by side."""
        marked = self.marked()
        if len(marked) == 2:
            self.show_screen("replay.Replay", marked[0].path, beside=marked[1].path)
        else:
            super().action_replay()

    def action_compare(self) -> None:
        self.show_screen("compare.Compare", [run.path for run in self.marked()])

    @work(group="ask")
    async def action_delete(self) -> None:
        """Delete runs after a question that names them; keep live runs."""
        from gaitsim.storage.manage import delete_run
        from gaitsim.tui.screens.questions import Confirm

        deleted = [run for run in self._chosen() if not run.evolves]
        kept = [run.name for run in self._chosen() if run.evolves]
        if not deleted:
            return
        one = len(deleted) == 1
        about = str(deleted[0].path) if one else _join_names([run.name for run in deleted])
        about += "\nIts" if one else "\nTheir"
        about += " champions, exports and notes are deleted too. This cannot be undone."
        if kept:
            about += (
                f"\n\nNot deleted, because they evolve: {_join_names(kept)}. Press x to stop them."
            )
        what = f"the run {deleted[0].name}" if one else f"{len(deleted)} runs"
        question = Confirm(f"Delete {what}?", "Delete", about, danger=True)
        if await self.app.push_screen_wait(question):
            for run in deleted:
                await self._try(delete_run, run.path)
                self.run_changed(run.path, run.path)

    @work(group="ask")
    async def action_rename(self) -> None:
        from gaitsim.storage.manage import check_name, rename_run
        from gaitsim.tui.screens.questions import Ask

        run = self.current()
        if run is None:
            return
        path = run.path

        def check(name: str) -> None:
            if name != path.name:
                check_name(path, name)

        about = f"This renames its folder in {path.parent}."
        question = Ask(f"New name of the run {path.name}", path.name, check, about)
        name = await self.app.push_screen_wait(question)
        if name is not None and name != path.name:
            self.renaming = True
            new = await self._try(rename_run, path, name)
            self.renaming = False
            if new is not None:
                self.run_changed(path, new)

    @work(group="ask")
    async def action_note(self) -> None:
        from gaitsim.storage.manage import read_note, write_note
        from gaitsim.tui.screens.questions import NoteDialog

        run = self.current()
        if run is None:
            return
        before = await self._try(read_note, run.path)
        text = await self.app.push_screen_wait(NoteDialog(run.name, before or ""))
        if text is not None:
            await self._try(write_note, run.path, text)
            self.run_changed(run.path, run.path)

    @work(group="ask")
    async def action_gallery(self) -> None:
        """Write a web site of all runs in the folder."""
        from gaitsim.tui.screens.questions import Ask

        about = "A card for each run, and a page that plays it. An existing gallery is replaced."
        question = Ask("Folder of the gallery", "site", about=about)
        out = await self.app.push_screen_wait(question)
        if out is not None:
            folder = str(self.gaitsim.folder)
            self.gaitsim.start_task(("gallery", folder, "--out", out), opens=not self.app.is_web)

    @work(group="stop")
    async def action_stop(self) -> None:
        from gaitsim.live.process import stop

        runs = [run for run in self._chosen() if run.evolves]
        names = _join_names([run.name for run in runs])
        self.notify(names, title="Stopping after the current generation", markup=False)
        await asyncio.gather(*(self._try(stop, run.path) for run in runs))
        for run in runs:
            self.run_changed(run.path, run.path)

    async def _try(self, do: Callable[..., T], *arguments: object) -> T | None:
        """Call a function in a thread; if it fails, show its error and return None."""
        try:
            return await asyncio.to_thread(do, *arguments)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        return None


def _join_names(names: Sequence[str]) -> str:
    """Join names with commas; beyond `LISTED`, add the number of the others."""
    shown = ", ".join(names[:LISTED])
    return shown if len(names) <= LISTED else f"{shown} and {len(names) - LISTED} more"
