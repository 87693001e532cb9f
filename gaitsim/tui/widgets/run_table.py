"""The table of runs, sorted by any value, and details of a run."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

from rich.cells import cell_len
from rich.segment import Segment
from rich.text import Text
from textual.events import Click
from textual.geometry import Region, Size
from textual.message import Message
from textual.scroll_view import ScrollView
from textual.strip import Strip

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.run_cells import run_cell
from gaitsim.render.terminal.text import duration, number, visible, visible_lines
from gaitsim.storage.overview import Overview
from gaitsim.storage.query import sort_runs, value_of
from gaitsim.tui.formatting import clip, clip_name
from gaitsim.tui.keys import bindings

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
LINES = 3  # maximum lines of a note
SEPARATOR = "  ·  "
Comparable = tuple[str, str]  # the body and the fitness of runs whose scores can be compared
Scale = tuple[float, float]  # the scores drawn lowest and highest

CURVE = "curve"  # the column that is always last, if there is room
# The minimum width of each column in cells; other columns are options and terms.
WIDTHS = {
    "name": 14,
    "body": 9,
    "fitness": 17,
    "search": 12,
    "generation": 11,
    "score": 8,
    CURVE: 5,
    "state": 10,
    "tag": 12,
    "note": 20,
    "time": 10,
    "evaluations": 11,
    "age": 6,
}
OTHER = 8  # minimum width of other columns
WIDEST = 18  # maximum width for the title of another column
NARROW = ("name", "body", "generation", "score", "state", "age")
USUAL = ("name", "body", "fitness", "generation", "score", "state", "age")
WIDE, WIDER = 110, 120  # minimum widths in cells for the columns of the fitness, and of tags
GAP = 2  # cells between two columns
MARK, NO_MARK = "◆ ", "◇ "
# Columns that are sorted from the largest value first, and those aligned right.
DESCENDING_FIRST = {"generation", "score", "evaluations", "time"}
RIGHT = {"generation", "score", "evaluations", "time", "age", "seed", "stage", "generations"}
_sparkline = lru_cache(maxsize=4096)(sparkline)


def layout(width: int, names: Sequence[str] = (), *, tagged: bool = False) -> dict[str, int]:
    """Return the width of each column in a table; columns without room are left out.

    Args:
        width: width of the table, cells.
        names: keys of the columns; () for the usual ones.
        tagged: whether a run has tags, which the usual columns then show if there is room.
    """
    usual = [*(USUAL if width >= WIDE else NARROW)]
    if width >= WIDER and tagged:
        usual.insert(-2, "tag")
    found: dict[str, int] = {}
    left = width - 1
    for name in names or usual:
        least = WIDTHS.get(name) or max(OTHER, min(len(name) + 1, WIDEST))
        if left >= least + GAP:
            found[name] = least
            left -= least + GAP
    if left >= WIDTHS[CURVE] + GAP:
        # The name gets part of the remaining width, the curve the rest.
        left -= WIDTHS[CURVE] + GAP
        more = min(left, 16) if "name" in found else 0
        found |= {"name": found["name"] + more} if more else {}
        ends = [name for name in ("state", "tag", "age") if name in found]
        curve = WIDTHS[CURVE] + min(left - more, 40)
        found = {
            **{name: size for name, size in found.items() if name not in ends},
            CURVE: curve,
            **{name: size for name, size in found.items() if name in ends},
        }
    return found


class RunTable(ScrollView, can_focus=True):
    """A table of runs. The cursor stays on its run when others appear or disappear.

    Only the rows in view are drawn, so that a filter over 1,000 runs shows its result at once.

    Attributes:
        chosen: keys of the columns; () for the usual ones.
        sort: key to sort by, with `-` for descending order; '' for the latest first.
        marked: marked runs.
        shown: runs in the order of the rows.
        columns: width of each column by key.
        cursor_row: index of the row under the cursor.
    """

    class Moved(Message):
        """Posted when another row is under the cursor."""

    class Opened(Message):
        """Posted when the run under the cursor is to be opened."""

    class Marked(Message):
        """Posted when the marked runs have changed."""

    class Arranged(Message):
        """Posted when the user has changed the columns or the order."""

    ALLOW_SELECT = False
    BINDINGS = bindings("home table")
    COMPONENT_CLASSES: ClassVar[set[str]] = {"table--header", "table--cursor"}
    DEFAULT_CSS = """
    RunTable {
        overflow-x: hidden; scrollbar-size-vertical: 1;
        & > .table--header { color: $text-muted; text-style: bold; }
        & > .table--cursor {
            background: $block-cursor-blurred-background;
            color: $block-cursor-blurred-foreground;
            text-style: $block-cursor-blurred-text-style;
        }
        &:focus > .table--cursor {
            background: $block-cursor-background; color: $block-cursor-foreground;
            text-style: $block-cursor-text-style;
        }
    }
    """

    def __init__(self, columns: Sequence[str] = (), sort: str = "", **settings: Any) -> None:
        super().__init__(**settings)
        self.chosen, self.sort = tuple(columns), sort
        self.marked: set[Path] = set()
        self.shown: list[Overview] = []
        self.columns: dict[str, int] = {}
        self.cursor_row = 0
        self._runs: Sequence[Overview] = ()
        self._wanted: Sequence[Overview] = ()
        self._now = 0.0
        self._anchor: Path | None = None  # the run that was marked or unmarked last
        self._scales: Mapping[Comparable, Scale] = {}

    # What is shown

    @property
    def run(self) -> Overview | None:
        """The run under the cursor."""
        return self.shown[self.cursor_row] if self.cursor_row < len(self.shown) else None

    def scale(self, run: Overview) -> Scale | None:
        """Return the scale of the curve of a run; None if it has no scores."""
        return self._scales.get(_comparable(run))

    def show(self, runs: Sequence[Overview], wanted: Sequence[Overview], now: float) -> None:
        """Show some runs.

        Args:
            runs: all runs in the folder.
            wanted: runs to show.
            now: time in seconds since 1970.
        """
        self._runs, self._wanted, self._now = runs, wanted, now
        self.marked &= {run.path for run in runs}
        self._scales = scales(runs)
        run, place = self.run, self.cursor_row
        self.shown = sorted_runs(wanted, self.sort)
        self._draw()
        paths = [one.path for one in self.shown]
        at = paths.index(run.path) if run is not None and run.path in paths else place
        self._move_to(at, seen=at != place)

    def show_columns(self, columns: Sequence[str], sort: str) -> None:
        """Change the columns and the order."""
        self.chosen, self.sort = tuple(columns), sort
        self.show(self._runs, self._wanted, self._now)
        self.post_message(self.Arranged())

    def _draw(self) -> None:
        tagged = any(run.tags for run in self._runs)
        self.columns = layout(self.size.width, self.chosen, tagged=tagged)
        self.virtual_size = Size(self.size.width, len(self.shown) + 1)
        self.refresh()

    def cells(self, run: Overview) -> list[Text]:
        """Return the cells of a run, as wide as their columns."""
        return [self._cell(run, name, width) for name, width in self.columns.items()]

    def render_line(self, y: int) -> Strip:
        """Return a line: the titles, or a row."""
        width = self.size.width
        at = y - 1 + round(self.scroll_offset.y)
        if y == 0:
            style = self.get_component_rich_style("table--header")
            cells = [self._title(*column) for column in self.columns.items()]
        elif at < len(self.shown):
            style, cells = self.rich_style, self.cells(self.shown[at])
        else:
            return Strip.blank(width, self.rich_style)
        line = Text(" ", end="", no_wrap=True) + Text(" " * GAP).join(cells)
        strip = Strip(line.render(self.app.console)).adjust_cell_length(width)
        if y and at == self.cursor_row:
            cursor = self.get_component_rich_style("table--cursor")
            return Strip([Segment(segment.text, cursor) for segment in strip], width)
        return strip.apply_style(self.rich_style + style)

    def _title(self, name: str, width: int) -> Text:
        key = self.sort.removeprefix("-") or "age"
        arrow = ("▼" if self.sort.startswith("-") else "▲") if name == key else ""
        return _fit(Text(clip(name, width - len(arrow)) + arrow), width, right=self._right(name))

    def _right(self, name: str) -> bool:
        """Return whether the cells of a column are aligned right."""
        if name in WIDTHS or name in RIGHT:
            return name in RIGHT
        values = (value_of(run, name) for run in self._runs)
        return isinstance(next((one for one in values if one is not None), ""), int | float)

    def _cell(self, run: Overview, name: str, width: int) -> Text:
        style = ""
        match name:
            case "name":
                marked = run.path in self.marked
                mark = (MARK, "$primary") if marked else (NO_MARK, "dim")
                text = Text.assemble(mark, (clip_name(run.name, width - len(MARK)), "bold"))
                return _fit(text, width)
            case "curve":
                shown, style = _sparkline(run.curve, width, self.scale(run)), "$primary"
            case "state":
                shown, colour = STATES[run.state]
                style = f"${colour}"
            case "tag":
                shown, style = ", ".join(run.tags), "$secondary"
            case _:
                shown = run_cell(run, name, self._now)
        return _fit(Text(clip(shown, width), style), width, right=self._right(name))

    # The cursor

    def _move_to(self, row: int, *, seen: bool = True) -> None:
        """Move the cursor to a row; if `seen`, scroll it into view."""
        before, self.cursor_row = self.cursor_row, max(0, min(row, len(self.shown) - 1))
        if seen:
            room, top = max(self.size.height - 1, 1), round(self.scroll_target_y)
            if not top <= self.cursor_row < top + room:
                first = self.cursor_row if self.cursor_row < top else self.cursor_row - room + 1
                self.scroll_to(y=first, animate=False, force=True)
        if self.cursor_row != before:
            for changed in (before, self.cursor_row):
                line = changed + 1 - round(self.scroll_offset.y)
                self.refresh(Region(0, line, self.size.width, 1))
            self.post_message(self.Moved())

    def action_scroll_up(self) -> None:
        self._move_to(self.cursor_row - 1)

    def action_scroll_down(self) -> None:
        self._move_to(self.cursor_row + 1)

    def action_page_up(self) -> None:
        self._move_to(self.cursor_row - max(self.size.height - 2, 1))

    def action_page_down(self) -> None:
        self._move_to(self.cursor_row + max(self.size.height - 2, 1))

    def action_scroll_home(self) -> None:
        self._move_to(0)

    def action_scroll_end(self) -> None:
        self._move_to(len(self.shown) - 1)

    def on_resize(self) -> None:
        self._draw()
        self._move_to(self.cursor_row)

    def action_select_cursor(self) -> None:
        self.post_message(self.Opened())

    def on_click(self, event: Click) -> None:
        """Highlight a run; mark it if its mark is clicked, or with Ctrl; open it if highlighted.

        A click on a title sorts by its column; with Shift, a click marks a range of runs.
        """
        event.stop()
        at = event.y - 1 + round(self.scroll_offset.y)
        if event.y == 0:
            self._sort_at(event.x)
        elif at < len(self.shown):
            highlighted = at == self.cursor_row
            self._move_to(at, seen=False)
            if event.shift:
                self.action_mark_range()
            elif event.ctrl or event.x <= len(MARK):
                self._toggle()
            elif highlighted:
                self.action_select_cursor()

    # The order

    def _sort_at(self, x: int) -> None:
        end = 1
        for name, width in self.columns.items():
            end += width + GAP
            if x < end:
                self.sort_by("time" if name == CURVE else name)
                return

    def sort_by(self, key: str) -> None:
        """Sort by the value of a key; if it is the current one, reverse the order."""
        before = self.sort or "age"
        down = key in DESCENDING_FIRST
        if key == before.removeprefix("-"):
            down = not before.startswith("-")
        self.show_columns(self.chosen, f"-{key}" if down else key)

    def action_sort(self) -> None:
        names = [name for name in self.columns if name != CURVE]
        key = (self.sort or "age").removeprefix("-")
        at = names.index(key) if key in names else -1
        self.sort_by(names[(at + 1) % len(names)])

    def action_reverse(self) -> None:
        self.sort_by((self.sort or "age").removeprefix("-"))

    # Marks

    def action_mark(self) -> None:
        """Mark or unmark the runs under the cursor, and move to the next row."""
        self._toggle()
        self.action_scroll_down()

    def _toggle(self) -> None:
        """Mark or unmark the run under the cursor."""
        if self.run is not None:
            self._anchor = self.run.path
            self.mark(self.marked ^ {self.run.path})

    def action_mark_range(self) -> None:
        """Mark the runs from the one marked last to the cursor."""
        paths = [run.path for run in self.shown]
        anchor = paths.index(self._anchor) if self._anchor in paths else self.cursor_row
        first, last = sorted((anchor, self.cursor_row))
        self.mark(self.marked | {*paths[first : last + 1]})
        if self.run is not None:
            self._anchor = self.run.path

    def action_mark_all(self) -> None:
        self.mark(self.marked | {run.path for run in self.shown})

    def action_invert(self) -> None:
        self.mark(self.marked ^ {run.path for run in self.shown})

    def action_unmark(self) -> None:
        self.mark(set())

    def mark(self, paths: Collection[Path]) -> None:
        """Replace the marks."""
        self.marked = {*paths}
        self.refresh()
        self.post_message(self.Marked())

    def run_renamed(self, old: Path, new: Path) -> None:
        """Keep the mark and the cursor on a renamed run."""
        self.shown = [replace(run, path=new) if run.path == old else run for run in self.shown]
        if old in self.marked:
            self.marked = self.marked - {old} | {new}


def sorted_runs(runs: Iterable[Overview], sort: str) -> list[Overview]:
    """Return runs sorted by a key, with `-` for descending order; '' is the latest first."""
    by_name = sorted(runs, key=lambda run: run.name.casefold())
    if sort.removeprefix("-") not in ("", "age"):
        return sort_runs(by_name, sort)
    # Running runs change all the time; they would swap places each time.
    return sorted(
        by_name,
        key=lambda run: -math.inf if run.state == "running" else -run.changed,
        reverse=sort.startswith("-"),
    )


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


def _fit(text: Text, width: int, *, right: bool = False) -> Text:
    """Pad or cut a text to a width in cells."""
    space = width - text.cell_len
    if space < 0:
        text.truncate(width)
    elif right:
        text.pad_left(space)
    else:
        text.pad_right(space)
    return text


def details(run: Overview, width: int, scale: Scale | None = None) -> Text:
    """Return the name, description, note, plugins, seed, stage and time of a run, or its problems.

    Args:
        run: the run.
        width: width of a line, cells.
        scale: scale of its curve in the table.
    """
    name = Text.assemble((visible(run.name), "bold"), "  ", (visible(run.description), ""))
    lines = [name, *(Text(visible(line), style="italic") for line in _first_lines(run.note))]
    for error in filter(None, (run.problem, run.failure)):
        lines.append(Text(visible_lines(str(error)), style="$error"))
    if run.problem is None:
        plugins = [
            visible(f"{'body' if kind == 'organism' else kind} {run.plugins[kind]}")
            for kind in KINDS
            if kind in run.plugins
        ]
        facts = [f"seed {run.seed}", f"evolved for {duration(run.seconds)}"]
        if run.stage > 1:
            facts.append(f"stage {run.stage}")
        if run.tags:
            facts.append(f"tags {', '.join(run.tags)}")
        if scale is not None:  # of all runs with this body and fitness
            facts.append(f"curve from {number(scale[0])} to {number(scale[1])}")
        lines += [
            Text("\n".join(_lines(plugins, width)), style="$secondary"),
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


def no_runs(folder: Path, among: str, words: str, problem: GaitsimError | None) -> Text:
    """Return the reason why no run is shown.

    Args:
        folder: folder of runs.
        among: the runs to which the filter was applied, such as 'the 3 runs'; '' without runs.
        words: the filter.
        problem: reason why the folder cannot be read; None if it can be read.
    """
    if problem is not None:
        return Text(visible_lines(str(problem)), style="$error")
    if among:
        return Text(f"None of {among} matches “{words}”.")
    return Text.assemble(
        (f"There are no runs in {folder}/ yet.\n\n", "bold"),
        "Press ",
        ("n", "bold"),
        " to create one, or in a terminal:\n\ngaitsim run spider",
        justify="center",
    )
