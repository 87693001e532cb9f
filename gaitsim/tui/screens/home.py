"""Home: all runs in a folder, kept up to date, and actions on them."""

import asyncio
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Container
from textual.reactive import reactive
from textual.widgets import Input, Static

from gaitsim.errors import GaitsimError
from gaitsim.tui.formatting import clip
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import PaletteCommand, RunChoice
from gaitsim.tui.screens.run_actions import RunActions

if TYPE_CHECKING:
    from gaitsim.steering import SteeredDrive
    from gaitsim.storage.growing import RunsWatcher
    from gaitsim.storage.overview import Overview
    from gaitsim.storage.query import Query
    from gaitsim.tui.screens.run_preview import RunPreview
    from gaitsim.tui.widgets.run_table import RunTable

LOOKING = "Looking for runs …"
BESIDE, BELOW = (150, 20), (110, 30)  # minimum columns and rows with a preview
EVERY = 1.0  # seconds between two scans of the folder
ACTIONS = (
    "delete", "stop", "rename", "note", "tag", "files", "replay", "map", "why", "compare", "export",
    "filter", "on_individual", "steer", "back", "undo",
)  # fmt: skip


class Home(RunActions):
    """The table of runs, with details of the one under the cursor.

    Attributes:
        runs: runs found by the last scan; None until all have been read once.
        filter: query of the runs to show, as typed.
    """

    AUTO_FOCUS = ""  # not the filter, which would take letters; the table later
    HELP_TEXT = """
The runs in a folder, the latest first. The table follows live runs, including those started in
other terminals.

- **Open** a run to watch, continue or steer it; **new** creates one. A click on the highlighted
  run also opens it.
- **Mark** runs with space, or by a click on ◇; `V` marks all from the last mark to the cursor, `a`
  all that are shown. Then **compare** their curves and options, or **replay** two side by side.
  **Stop**, **tag** and **delete** apply to all marked runs.
- **Delete** moves runs to the trash for 30 days. `z` undoes the last deletion, name, note or tags;
  `Z` lists the trash.
- **Export** gait files, plots, videos and analyses of a run in the background.
- **Note** attaches a note to a run, **rename** changes its name.
- `v` **verifies** a run.
- A click on a column's title, or `s`, sorts by that column. `C` chooses **columns**: any option and
  any term of the score.
- `P` shows or hides the **preview**, in terminals of at least 110 × 30 characters.
- `/` filters by words and values: `spider score>2`, `state:failed`, `body:spider`, `tag:good`,
  `-tag:bad`, `evolution.population>50`, `age<2d`.
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
        self._height, self._shown_details = 0, Text()
        self._next_part = 1  # number of runs at which the table is next updated
        self._next_count = 0.0  # time of the next count, which takes as long to draw as ten runs
        self._count = ""
        self._changes = 0  # number of changes made by this screen
        self._reading = Lock()
        self._query: Query | None = None  # the last valid one
        self._preview: RunPreview | None = None

    def content(self) -> ComposeResult:
        """Compose the screen; the table is mounted once runs are read."""
        yield Input(
            placeholder="words, score>2, state:failed, tag:good, …", id="filter", compact=True
        )
        yield Static(id="filter-problem")
        with Container(id="listing"):
            yield Static(LOOKING, id="empty")
        yield Static(id="details")

    def on_mount(self) -> None:
        """Scan the folder after the first paint, as reading runs imports NumPy."""
        self.sub_title = f"{self.gaitsim.folder}/"
        self.query_one("#filter").display = False
        self.query_one("#filter-problem").display = False
        self.query_one("#details").display = False
        self.call_after_refresh(self.look)
        self.set_interval(EVERY, self._look_again)

    def _look_again(self) -> None:
        # Not `is_current`, which is also True for the screen directly below the top one.
        if self.is_active and not self.is_busy("look"):
            self.look()

    def on_screen_resume(self) -> None:
        if self.runs is not None:
            if not self.listed:  # until the scan, as a run may have been created
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
        self.runs = self.listed = found
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
            self.listed = runs or self.listed
            self._show() if runs else self._title()

    def _show(self) -> None:
        """Show the found runs."""
        if self.runs is None and not self.listed:
            return
        from gaitsim.tui.widgets.run_table import RunTable

        if self._table is None:
            self._table = RunTable(self.gaitsim.columns, self.gaitsim.sort, id="runs")
            self.query_one("#listing").mount(self._table)
            self.call_after_refresh(self._show)
            return
        self._table.show(self.listed, self._wanted(), self.gaitsim.clock())
        empty = self.query_one("#empty", Static)
        empty.display = not self._table.shown
        self._table.display = bool(self._table.shown)
        if empty.display:
            from gaitsim.tui.widgets.run_table import no_runs

            folder = self.gaitsim.folder
            among = f"the {len(self.listed)} runs" if self.listed else ""
            among += " read so far" if among and self.runs is None else ""
            empty.update(no_runs(folder, among, self.filter, self._problem))
        elif self.focused is None:
            self.set_focus(self._table)
        self._title()
        self._details()

    def _wanted(self) -> "list[Overview]":
        """Return the runs that fulfil the filter; the last word is ignored while it is invalid."""
        text, problem = self.filter.strip(), ""
        query, found = None, None
        if text:
            from gaitsim.storage.query import parse_query

            for shorter in (text, text.rpartition(" ")[0]):
                try:
                    query = parse_query(shorter)
                    found = query.select(self.listed)
                    break
                except GaitsimError as error:
                    query = self._query
                    hint = error.remedy or error.allowed
                    problem = problem or (f"{error.what}; {hint}" if hint else error.what)
        self._query = query
        line = self.query_one("#filter-problem", Static)
        line.display = bool(problem)
        line.update(Text(clip(problem, max(self.size.width - 2, 1))))
        if found is not None:
            return found
        return [run for run in self.listed if query is None or query.matches(run)]

    def _title(self) -> None:
        """Show the number of runs, and how many are in each state that needs attention."""
        states = Counter[str](run.state for run in self.listed)
        wanted = ("running", "paused", "queued", "failed")
        counts = [f"{states[state]} {state}" for state in wanted if states[state]]
        table, count = self._table, self._count
        if table is not None and self.runs is not None and self._query is not None:
            count = f"{len(table.shown)} of {count}"
        if table is not None and table.marked:
            counts.insert(0, f"{len(table.marked)} marked")
        self.sub_title = " · ".join([f"{count} in {self.gaitsim.folder}/", *counts])

    def on_run_table_moved(self) -> None:
        self._details()

    def on_run_table_marked(self) -> None:
        self._title()
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
            text = details(run, width, self._table.scale(run))
            if text != self._shown_details:
                height = len(text.wrap(self.app.console, width))
                # A new layout at each move of the cursor would make it lag.
                panel.update(text, layout=height != self._height)
                self._height, self._shown_details = height, text
        self._show_preview(run)
        self.offers = [self.check_action(name, ()) for name in ACTIONS]

    def _show_preview(self, run: "Overview | None") -> None:
        """Show the champion of a run beside or below the list, if there is room."""
        shown = self.gaitsim.preview and bool(self.preview_place) and bool(self.listed)
        if self._preview is None:
            if not shown or self.runs is None:
                return
            from gaitsim.tui.screens.run_preview import RunPreview

            self._preview = RunPreview()
            self.query_one("#listing").mount(self._preview)
        beside = shown and self.preview_place == "beside"
        for part in (self.query_one("#listing"), self._preview):
            part.set_class(beside, "-beside")
        self._preview.display = shown
        self._preview.show(run if shown else None)

    @property
    def preview_place(self) -> str:
        """The place of the preview: 'beside' or 'below' the list; '' without room."""
        width, height = self.size
        if width >= BESIDE[0] and height >= BESIDE[1]:
            return "beside"
        return "below" if width >= BELOW[0] and height >= BELOW[1] else ""

    def action_preview(self) -> None:
        self.gaitsim.preview = not self.gaitsim.preview
        self.gaitsim.remember("preview", self.gaitsim.preview)
        self._details()

    def current(self) -> "Overview | None":
        """Return the run under the cursor."""
        return self._table.run if self._table is not None and self._table.display else None

    def marked(self) -> "list[Overview]":
        """Return the marked runs, in the order of the list."""
        marked = self._table.marked if self._table is not None else set()
        return [run for run in self.listed if run.path in marked] if marked else []

    def chosen(self) -> "list[Overview]":
        """Return the marked runs, or if none is marked, the one under the cursor."""
        run = self.current()
        return self.marked() or ([] if run is None else [run])

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
    def _entered(self, event: Input.Submitted) -> None:
        event.input.display = bool(event.value.strip())
        self.set_focus(self._table)

    def action_filter(self) -> None:
        box = self.query_one("#filter", Input)
        box.display = True
        self.set_focus(box)  # not the deferred `box.focus()`: letters would act as commands

    def action_back(self) -> None:
        """Remove the filter, or else the marks."""
        box = self.query_one("#filter", Input)
        if box.display:
            self._set_filter("")
        elif self._table is not None:
            self._table.action_unmark()

    def _set_filter(self, query: str) -> None:
        box = self.query_one("#filter", Input)
        box.value, box.display = query, bool(query)
        self.filter = query
        self.set_focus(self._table)

    @property
    def to_verify(self) -> Path | None:
        run = self.current()
        return run.path if run and run.generation and run.problem is None else None

    def command_line(self) -> str:
        """Return the command of the run under the cursor."""
        from gaitsim.storage.files.folder import (
            command,  # takes 0.25 s, so not before the first paint
        )

        run = self.current()
        return command("show", run.path) if run is not None else ""

    def _list_command(self) -> str:
        """Return the command that prints the list, with its filter, columns and order."""
        from gaitsim.storage.files.folder import command

        assert self._table is not None, "it shows the list"
        options = {
            "--where": self.filter.strip(),
            "--columns": ",".join(self._table.chosen),
            "--sort": self._table.sort or "age",
        }
        given = [word for name, text in options.items() if text for word in (name, text)]
        return command("runs", self.gaitsim.folder, *given)

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each preset."""
        from gaitsim.registry import EXPERIMENTS, STEER, entries

        if self._table is not None:
            yield PaletteCommand(
                "Copy the list's command",
                "Copy the command that prints these runs, sorted like here",
                lambda: self.gaitsim.copy(self._list_command()),
            )
        for name in entries(EXPERIMENTS):
            yield PaletteCommand(
                f"New run: {name}",
                f"Create a run from the preset {name}",
                partial(self.show_screen, "new.New", name),
            )
        for name in entries(STEER):
            yield PaletteCommand(
                f"Steer: {name}",
                f"Steer the body of the preset {name} yourself with the arrow keys",
                partial(self._steer, name),
            )
        yield from super().palette()

    def _steer(self, name: str) -> None:
        from gaitsim.experiment import load_experiment
        from gaitsim.steering import create_drive
        from gaitsim.storage.files.folder import command

        def drive() -> SteeredDrive:
            return create_drive(load_experiment(name), {})

        self.show_screen("steering.Steering", drive, command("steer", name))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "back":
            marked = self._table is not None and bool(self._table.marked)
            return marked or bool(self.is_mounted and self.query_one("#filter").display)
        if action == "undo":
            return bool(self._done)
        if action == "preview":
            return self.is_mounted and bool(self.preview_place)
        return super().check_action(action, parameters)

    # Columns and order

    @work(group="ask")
    async def action_columns(self) -> None:
        """Choose the columns, which are remembered."""
        from gaitsim.storage.query import KEYS, check_keys
        from gaitsim.tui.products import split_names
        from gaitsim.tui.screens.questions import Ask

        if self._table is None:
            return
        now = self._table.chosen or [name for name in self._table.columns if name != "curve"]
        others = {key for run in self.listed for key in (*run.options, *run.terms)}
        about = (
            f"Keys separated by commas, or nothing for the usual columns: {', '.join(KEYS)}, or an "
            "option or term such as evolution.population"
        )
        ask = Ask(
            "Columns",
            ", ".join(now),
            lambda text: check_keys(split_names(text), self.listed),
            about,
            words=[*KEYS, *sorted(others)],
            separator=",",
            empty=True,
        )
        answer = await self.app.push_screen_wait(ask)
        if answer is not None:
            self._table.show_columns(split_names(answer), self._table.sort)

    def on_run_table_arranged(self) -> None:
        """Remember the columns and the order."""
        assert self._table is not None, "it posted the message"
        self.gaitsim.columns, self.gaitsim.sort = self._table.chosen, self._table.sort
        self.gaitsim.remember("columns", [*self._table.chosen])
        self.gaitsim.remember("sort", self._table.sort)

    # Actions on runs

    @property
    def choice(self) -> RunChoice | None:
        run = self.current()
        others = [one.path for one in self.marked() if one is not run]
        return None if run is None else RunChoice(run.path, others=others)

    def obstacle(self, action: str) -> str:
        run, chosen = self.current(), self.chosen()
        needs_run = (
            *("select_cursor", "mark", "replay", "why", "export", "on_individual"),
            *("map", "note", "rename", "files", "steer"),
        )
        if action in (*needs_run, "delete", "stop", "tag") and not chosen:
            return "There is no run here; press n to create one."
        match action:
            case "delete" if all(one.evolves for one in chosen):
                return "The run is evolving; press x to stop it first."
            case "stop" if not any(one.evolves for one in chosen):
                return "The run is not evolving."
            case "rename" if run is not None and run.evolves:
                return "The run is evolving; press x to stop it first."
            case "replay" | "why" | "export" | "map" | "on_individual" | "steer" if run:
                if run.problem is not None:
                    return "The run cannot be read; see the reason below the list."
                if run.generation == 0:
                    return "The run has no finished generation yet; open it and let it evolve."
            case "undo" if not self._done:
                return "Nothing has been deleted, renamed, tagged or annotated here."
            case "compare" if len(self.marked()) < 2:
                return "Mark two or more runs with space first."
            case "filter" | "columns" if not self.listed:
                return "There are no runs to choose from."
        return super().obstacle(action)

    def on_run_table_opened(self) -> None:
        self.open_listed(self.current())

    def action_new(self) -> None:
        self.ask_preset()

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
