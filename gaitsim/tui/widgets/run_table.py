"""The table of runs, sorted, filtered and updated cell by cell, and details of a run."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rich.cells import cell_len
from rich.text import Text
from textual.events import Click
from textual.message import Message
from textual.widgets import DataTable

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import age, ago, duration, number, visible, visible_lines
from gaitsim.storage.overview import Overview
from gaitsim.tui.formatting import clip, clip_name
from gaitsim.tui.keys import bindings
from gaitsim.tui.themes import INKS

STATES = {
    "running": ("● running", "success"),
    "queued": ("◌ queued", "secondary"),
    "paused": ("‖ paused", "warning"),
    "stopped": ("■ stopped", "warning"),
    "failed": ("✗ failed", "error"),
    "finished": ("✓ finished", "primary"),
    "older format": ("✗ too old", "warning"),
    "newer format": ("✗ too new", "warning"),
    "damaged": ("✗ damaged", "error"),
}
_ORDER = list(STATES)
LINES = 3  # maximum lines of a note
SEPARATOR = "  ·  "
Comparable = tuple[str, str]  # the body and the fitness of runs whose scores can be compared
Scale = tuple[float, float]  # the scores drawn lowest and highest


@dataclass(frozen=True)
class Column:
    """A column of the table.

    Attributes:
        name: key of the column.
        width: minimum width in cells.
        sort: sort key of a run.
        right: whether the cells are aligned right.
        titles: titles, the longest first; () for the name.
    """

    name: str
    width: int
    sort: Callable[[Overview], Any]
    right: bool = False
    titles: tuple[str, ...] = ()


COLUMNS = {
    "run": Column("run", 14, lambda run: run.name.casefold()),
    "body": Column("body", 9, lambda run: run.plugins.get("organism", "")),
    "fitness": Column("fitness", 17, lambda run: run.plugins.get("fitness", "")),
    "generation": Column("generation", 11, lambda run: run.generation, right=True),
    "best": Column(
        "best",
        8,
        lambda run: float("-inf") if run.best is None else run.best,
        right=True,
        titles=("best score", "score"),
    ),
    "curve": Column("curve", 5, lambda run: run.seconds),
    "state": Column("state", 10, lambda run: _ORDER.index(run.state)),
    # Running runs change all the time; they would swap places each time.
    "changed": Column(
        "changed", 8, lambda run: math.inf if run.state == "running" else run.changed, right=True
    ),
}
NARROW = ("run", "body", "generation", "best", "curve", "state", "changed")
WIDE = 110  # minimum width in cells for the column of the fitness, and for long titles
_sparkline = lru_cache(maxsize=4096)(sparkline)  # a third of a row's cost
MARK, NO_MARK = "◆ ", "◇ "
# Columns that are sorted from the largest value first.
DESCENDING_FIRST = {"generation", "best", "curve", "changed"}


def columns(width: int) -> list[tuple[Column, int]]:
    """Return the columns for a table of a width, and the width of each."""
    wide = width >= WIDE
    shown = [COLUMNS[name] for name in (COLUMNS if wide else NARROW)]
    more = {"best": 3, "changed": 2} if wide else {}  # for "best score▼" and "12 min ago"
    left = max(0, width - 1 - sum(column.width + 2 for column in shown) - sum(more.values()))
    # The name gets part of the remaining width, the curve the rest.
    more["run"] = min(left, 16)
    more["curve"] = min(left - more["run"], 40)
    return [(column, column.width + more.get(column.name, 0)) for column in shown]


class RunTable(DataTable[Text]):
    """A table of runs. The cursor stays on its run when others appear or disappear.

    Attributes:
        order: name of the column to sort by.
        descending: whether the order is descending.
        marked: marked runs.
        shown: runs in the order of the rows.
    """

    class Marked(Message):
        """Posted when the marked runs have changed."""

    BINDINGS = bindings("home table")

    def __init__(self, **options: Any) -> None:
        super().__init__(cursor_type="row", **options)
        self.order = "changed"
        self.descending = True
        self.marked: set[Path] = set()
        self._last_shown: tuple[list[Overview], str, float] = ([], "", 0.0)
        self._layout: list[tuple[Column, int]] = []
        self.shown: list[Overview] = []
        self._cells: dict[Path, list[Text]] = {}
        self._scales: Mapping[Comparable, Scale] = {}

    @property
    def run(self) -> Overview | None:
        """The run under the cursor."""
        row = self.cursor_row
        return self.shown[row] if 0 <= row < len(self.shown) else None

    def scale(self, run: Overview) -> Scale | None:
        """Return the scale of the curve of a run; None if it has no scores."""
        return self._scales.get(_comparable(run))

    def show(self, runs: Iterable[Overview], words: str, now: float) -> None:
        """Show the runs that match all of `words`; `now` is the time in seconds since 1970."""
        found = list(runs)
        self._last_shown = (found, words, now)
        self.marked &= {run.path for run in found}
        wanted = sorted(_matching(found, words), key=COLUMNS["run"].sort)
        wanted.sort(key=COLUMNS[self.order].sort, reverse=self.descending)
        layout = columns(self.size.width)
        self._scales = scales(found)
        cells = {run.path: self._row(run, layout, now) for run in wanted}
        before = [run.path for run in self.shown]
        if [*cells][: len(before)] == before and layout == self._layout:
            self._update(cells)
        else:
            self._build(layout, cells, self.run)
        self.shown, self._cells = wanted, cells

    def sort_by(self, name: str) -> None:
        """Sort by a column; if it is the current one, reverse the order."""
        self.descending = not self.descending if name == self.order else name in DESCENDING_FIRST
        self.order = name
        self._layout = []  # titles contain the arrow
        self.show(*self._last_shown)

    def on_data_table_header_selected(self, event: DataTable.HeaderSelected) -> None:
        event.stop()
        self.sort_by(str(event.column_key.value))

    def on_click(self, event: Click) -> None:
        """Highlight a run; mark it if its mark is clicked, or with Ctrl; open it if highlighted."""
        row = event.style.meta.get("row", -1)
        if not 0 <= row < len(self.shown):  # the click is on a title, or below the last row
            return
        event.prevent_default()
        event.stop()
        highlighted = row == self.cursor_row
        self.move_cursor(row=row)
        if event.ctrl or event.x <= len(MARK):
            self._mark(self.shown[row].path)
        elif highlighted:
            self.action_select_cursor()

    def action_sort(self) -> None:
        names = [column.name for column, _ in self._layout]
        at = names.index(self.order) if self.order in names else -1
        self.sort_by(names[(at + 1) % len(names)])

    def action_reverse(self) -> None:
        self.sort_by(self.order)

    def action_mark(self) -> None:
        """Mark or unmark the run under the cursor, and move to the next one."""
        if self.run is not None:
            self._mark(self.run.path)
            self.action_cursor_down()

    def _mark(self, path: Path) -> None:
        self.marked ^= {path}
        self.show(*self._last_shown)
        self.post_message(self.Marked())

    def run_renamed(self, old: Path, new: Path) -> None:
        """Keep the mark and the cursor on a renamed run."""
        self.shown = [replace(run, path=new) if run.path == old else run for run in self.shown]
        if old in self.marked:
            self.marked = self.marked - {old} | {new}
        self._layout = []  # rows are keyed by path

    def _update(self, cells: dict[Path, list[Text]]) -> None:
        """Update the changed cells, and append new rows."""
        for path, row in cells.items():
            if path not in self._cells:
                self.add_row(*row, key=str(path))
                continue
            for (column, _), old, new in zip(self._layout, self._cells[path], row, strict=True):
                if old != new or old.spans != new.spans:
                    self.update_cell(str(path), column.name, new)

    def _build(
        self, layout: list[tuple[Column, int]], cells: dict[Path, list[Text]], at: Overview | None
    ) -> None:
        before = self.cursor_row
        if layout != self._layout:
            self.clear(columns=True)
            self._layout = layout
            for column, width in layout:
                self.add_column(self._title(column, width), key=column.name, width=width)
        else:
            self.clear()
        for path, row in cells.items():
            self.add_row(*row, key=str(path))
        places = list(cells)
        place = places.index(at.path) if at and at.path in cells else before
        self.move_cursor(row=min(place, len(places) - 1), animate=False)

    def _title(self, column: Column, width: int) -> Text:
        arrow = ("▼" if self.descending else "▲") if column.name == self.order else ""
        room = width - len(arrow)
        titles = column.titles or (column.name,)
        title = next((title for title in titles if len(title) <= room), titles[-1])
        title = f"{title[:room]}{arrow}"
        return _text(title, "", right=column.right)

    def _row(self, run: Overview, layout: Sequence[tuple[Column, int]], now: float) -> list[Text]:
        return [self._cell(run, column, width, now) for column, width in layout]

    def _cell(self, run: Overview, column: Column, width: int, now: float) -> Text:
        style = ""
        match column.name:
            case "run":
                marked = run.path in self.marked
                mark = (MARK, INKS["primary"]) if marked else (NO_MARK, "dim")
                name = clip_name(run.name, width - len(MARK))
                return Text.assemble(mark, (name, "bold"), no_wrap=True)
            case "body" | "fitness":
                text = run.plugins.get("organism" if column.name == "body" else "fitness", "")
            case "generation":
                text = f"{run.generation}/{run.generations}" if run.generations else ""
            case "best":
                text = "" if run.best is None else number(run.best, 4)
            case "curve":
                text = _sparkline(run.curve, width, self.scale(run))
                style = INKS["primary"]
            case "state":
                text, colour = STATES[run.state]
                style = INKS[colour]
            case _:
                text = (ago if width >= COLUMNS["changed"].width + 2 else age)(now - run.changed)
        return _text(clip(text, width), style, right=column.right)


def scales(runs: Iterable[Overview]) -> dict[Comparable, Scale]:
    """Return the lowest and highest score of the curves of all runs with a body and a fitness."""
    found: dict[Comparable, Scale] = {}
    for run in runs:
        if (one := _range(run.curve)) is not None:
            low, high = found.get(_comparable(run), one)
            found[_comparable(run)] = min(low, one[0]), max(high, one[1])
    return found


def _comparable(run: Overview) -> Comparable:
    return run.plugins.get("organism", ""), run.plugins.get("fitness", "")


@lru_cache(maxsize=4096)
def _range(curve: tuple[float, ...]) -> Scale | None:
    finite = [score for score in curve if math.isfinite(score)]
    return (min(finite), max(finite)) if finite else None


def _text(text: str, style: str, *, right: bool) -> Text:
    return Text(text, style=style, justify="right" if right else "left", no_wrap=True)


def _matching(runs: Iterable[Overview], words: str) -> list[Overview]:
    wanted = words.casefold().split()
    return [
        run
        for run in runs
        if all(
            word in f"{run.name} {' '.join(run.plugins.values())} {run.state} {run.note}".casefold()
            for word in wanted
        )
    ]


def details(
    run: Overview, colours: Mapping[str, str], width: int, scale: Scale | None = None
) -> Text:
    """Return the name, description, note, plugins, seed, stage and time of a run, or its problems.

    Args:
        run: the run.
        colours: colours by the name of the theme's variable.
        width: width of a line, cells.
        scale: scale of its curve in the table.
    """
    name = Text.assemble((visible(run.name), "bold"), "  ", (visible(run.description), ""))
    lines = [name, *(Text(visible(line), style="italic") for line in _first_lines(run.note))]
    for error in filter(None, (run.problem, run.failure)):
        lines.append(Text(visible_lines(str(error)), style=colours["error"]))
    if run.problem is None:
        plugins = [
            visible(f"{'body' if kind == 'organism' else kind} {run.plugins[kind]}")
            for kind in KINDS
            if kind in run.plugins
        ]
        facts = [f"seed {run.seed}", f"evolved for {duration(run.seconds)}"]
        if run.stage > 1:
            facts.append(f"stage {run.stage}")
        if scale is not None:  # of all runs with this body and fitness
            facts.append(f"curve from {number(scale[0])} to {number(scale[1])}")
        lines += [
            Text("\n".join(_lines(plugins, width)), style=colours["secondary"]),
            Text(SEPARATOR.join(facts), style="dim"),
        ]
    return Text("\n").join(lines)


def _lines(facts: Iterable[str], width: int) -> list[str]:
    """Join facts to lines of a width, without breaks within a fact."""
    lines: list[str] = []
    for fact in facts:
        longer = f"{lines[-1]}{SEPARATOR}{fact}" if lines else fact
        if lines and cell_len(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(fact)
    return lines


def _first_lines(note: str) -> list[str]:
    """Return the first lines of a note."""
    lines = note.splitlines()
    return lines if len(lines) <= LINES else [*lines[: LINES - 1], f"{lines[LINES - 1]} …"]


def no_runs(
    folder: Path, count: int, words: str, problem: GaitsimError | None, colours: Mapping[str, str]
) -> Text:
    """Return the reason why no run is shown.

    Args:
        folder: folder of runs.
        count: number of runs.
        words: words of the filter.
        problem: reason why the folder cannot be read; None if it can be read.
        colours: colours by the name of the theme's variable.
    """
    if problem is not None:
        return Text(visible_lines(str(problem)), style=colours["error"])
    if count:
        return Text(f"None of the {count} runs matches “{words}”.")
    return Text.assemble(
        (f"There are no runs in {folder}/ yet.\n\n", "bold"),
        "Press ",
        ("n", "bold"),
        " to create one, or in a terminal:\n\ngaitsim run spider",
        justify="center",
    )
