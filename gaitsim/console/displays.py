"""Displays of an evolving run: a live view on a terminal, plain lines, or JSON lines."""

import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from datetime import timedelta
from pathlib import Path
from typing import Any, Self

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.constrain import Constrain
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from gaitsim.console.printing import echo, notice, output, print_json
from gaitsim.evolution import Generation
from gaitsim.live.protocol import Snapshot
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import number, percent, visible
from gaitsim.storage.files.history import FIGURE, MEAN, figures_of, row
from gaitsim.storage.growing import Rows

Row = Mapping[str, Any]
"""A row of the history: one generation."""

BEST_SHOWN = 5  # individuals
# Messages for the states in which no generation is being evolved.
RESTING = {
    "preparing": "Preparing: the first run of a body compiles its kernels …",
    "queued": "Queued: starts when an earlier run ends.",
    "paused": "Paused.",
}
LONG = 2.0  # seconds from which a generation shows how much of it is scored
LINE_EVERY = 10.0  # seconds between lines about one generation in a log
STOPPING = "Stopping after this generation; press Ctrl-C again to stop at once."

CURVES = {"best": "green", "mean": "cyan", "diversity": "magenta"}
SCORES = ("best", "mean")  # the curves on the scale of the scores
WIDEST = 100  # characters
VALUE = 7  # characters, enough for most numbers
HEIGHT_ABOVE_TERMS = 8  # lines, including the table's header and the cursor's line


class Display:
    """A context manager that follows a run; entering and leaving do nothing by default.

    Args:
        path: folder of the run.
        known: current state of the run, with all rows of its history.
    """

    def __init__(self, path: Path, known: Snapshot) -> None:
        self._path, self._snapshot = path, known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Report that a stage starts.

        Args:
            number: number of the stage, counted from 1.
            first: first generation of the stage.
            changes: descriptions of the changed options.
            rescored: the last generation and its row, re-evaluated; None if the stage keeps the
                scores.
        """

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Show the state of the run and its newly finished generations."""

    def scored(self, share: float) -> None:
        """Show the share of the next generation that is scored; callable from any thread."""

    def warn(self, text: str) -> None:
        """Show a lasting message."""
        notice(text)

    def stopping(self) -> None:
        """Report that the run stops after this generation; called by a signal handler."""
        notice(STOPPING)


def stage_line(number: int, first: int, changes: Sequence[str]) -> str:
    return f"stage {number}, from generation {first}: {'; '.join(changes)}"


class LiveView(Display):
    """Progress, the curves of best, mean and diversity, and the terms of the best individuals.

    Terms are listed vertically, as in a sum, so that a narrow terminal shows fewer individuals
    rather than fewer terms.

    Args:
        path: folder of the run.
        known: current state of the run, with all rows of its history.
        console: console to draw on; standard output by default.
        clock: function that returns seconds since any fixed time.
    """

    def __init__(
        self,
        path: Path,
        known: Snapshot,
        console: Console | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(path, known)
        self._name = visible(path.name)
        self._row = _last(known.rows)
        # Scores of a different fitness or body would be on a different scale.
        first = known.scored_from - 1
        self._values = {
            name: [*known.rows.get(name, [])[first if name in SCORES else 0 :]] for name in CURVES
        }
        self._clock = clock
        # End times of the latest generations, for the current rather than the average speed.
        self._ends = deque([(clock(), self._done, known.evaluations)], maxlen=1000)
        self._begun = clock()
        self._stopping = False
        self._share = 0.0
        self._since = clock()  # start of the current state
        self._ended = False
        self._console = console or output()
        self._live = Live(self, console=self._console, refresh_per_second=8)

    def __enter__(self) -> Self:
        self._begun = self._clock()
        self._ends[0] = (self._begun, self._done, self._snapshot.evaluations)
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._live.stop()

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print a lasting line; re-evaluated scores restart their curves."""
        self._console.print(stage_line(number, first, changes), style="bold")
        if rescored is not None:
            self._snapshot, self._row = rescored, _last(rescored.rows)
            for name in SCORES:
                self._values[name] = [*rescored.rows.get(name, [])]

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Store the new state and rows; the screen is redrawn at its own rate."""
        for one in rows:
            for name, values in self._values.items():
                values.append(one[name])
        self._share = snapshot.scored
        if rows:
            self._row = rows[-1]
            self._ends.append((self._clock(), snapshot.generation, snapshot.evaluations))
        if snapshot.state != self._snapshot.state:
            self._since = self._clock()
        self._snapshot = snapshot  # set last, as another thread draws the screen

    def scored(self, share: float) -> None:
        """Store the share, which is shown if the generation takes a while."""
        self._share = share

    def warn(self, text: str) -> None:
        """Print a message above the view."""
        self._console.print(text, style="yellow")

    def stopping(self) -> None:
        """Show in the view that the run stops; the next refresh would overwrite a printed line."""
        self._stopping = True

    @property
    def _done(self) -> int:
        return self._snapshot.generation

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width = min(options.max_width, WIDEST)
        parts: list[RenderableType] = [self._header(width)]
        snapshot = self._snapshot
        if snapshot.top:
            parts.append(self._curves(width))
            if snapshot.islands:
                parts.append(self._island_scores(snapshot.islands))
            figures = figures_of(self._row)
            if figures:
                parts.append(self._figures(figures))
            parts.append(self._footer(snapshot))
            # At the end, the summary describes the champion.
            if not (self._ended and snapshot.state == "finished"):
                rows = (options.height or console.height) - HEIGHT_ABOVE_TERMS
                rows -= bool(snapshot.islands) + bool(figures)
                parts += ["", self._terms(snapshot, width, rows)]
        elif not self._ended and (foot := self._footer(snapshot)):
            parts.append(foot)
        yield Constrain(Group(*parts), width)

    def _header(self, width: int) -> Table:
        head = Table.grid(padding=(0, 1), expand=True)
        head.add_column(no_wrap=True, overflow="ellipsis", max_width=width // 3)
        head.add_column(ratio=1)
        head.add_column(no_wrap=True)
        head.add_column(no_wrap=True)
        total = self._snapshot.generations
        bar = ProgressBar(total=total, completed=self._done)
        name = Text(self._name, style="bold")
        head.add_row(name, bar, f"{self._done:,}/{total:,}", self._time())
        return head

    def _time(self) -> str:
        if self._ended:
            return f"in {_format_duration(self._clock() - self._begun)}"
        speed, _ = self._speed()
        left = self._snapshot.generations - self._done
        return f"{_format_duration(left / speed)} left" if speed else ""

    def _speed(self) -> tuple[float, float]:
        """Return generations and evaluations per second; 0 before the first is finished."""
        (start, first, before), (end, last, after) = self._ends[0], self._ends[-1]
        passed = end - start
        return ((last - first) / passed, (after - before) / passed) if passed > 0 else (0.0, 0.0)

    def _curves(self, width: int) -> Table:
        curves = Table.grid(padding=(0, 1))
        curves.add_column()
        curves.add_column(justify="right", min_width=VALUE, no_wrap=True)
        curves.add_column(no_wrap=True)
        for name, colour in CURVES.items():
            course = self._values[name] or [math.nan]  # empty after a re-evaluation
            room = width - max(map(len, CURVES)) - max(len(number(course[-1])), VALUE) - 2
            curve = Text(sparkline(course, max(room, 1)), style=colour)
            curves.add_row(name, number(course[-1]), curve)
        return curves

    def _island_scores(self, bests: Sequence[float]) -> Text:
        """Return the best score of each island on one line, the highest in bold."""
        line = Text("islands  ", no_wrap=True, overflow="ellipsis")
        for best in bests:
            line.append(
                f" {number(best):>{VALUE}}", style="bold green" if best == max(bests) else ""
            )
        return line

    def _figures(self, names: Sequence[str]) -> Text:
        """Return the search's own figures on one line."""
        parts = [f"{name} {number(self._row[FIGURE + name])}" for name in names]
        return Text("search    " + "   ".join(parts), no_wrap=True, overflow="ellipsis")

    def _footer(self, snapshot: Snapshot) -> Text:
        foot = Text(style="dim", no_wrap=True, overflow="ellipsis")
        note = self._note()
        if note and not self._ended:
            return foot.append(note, style="not dim yellow")
        parts = []
        if self._share and self._clock() - self._ends[-1][0] > LONG:
            parts = [f"generation {self._done + 1:,}: {percent(self._share)} scored"]
        _, rate = self._speed()
        parts += [f"{rate:,.0f} evaluations/s"] if rate else []
        if snapshot.champion is not None:
            parts.append(f"best of generation {snapshot.champion.generation:,}")
        if snapshot.stage > 1:
            parts.append(f"stage {snapshot.stage}")
        return foot.append(", ".join(parts))

    def _note(self) -> str:
        """Return why no generation is being evolved, with the time since then; '' if one is."""
        if self._stopping:
            return STOPPING
        note = RESTING.get(self._snapshot.state, "")
        seconds = int(self._clock() - self._since)
        return f"{note} {_format_duration(seconds)}" if note and seconds else note

    def _terms(self, snapshot: Snapshot, width: int, rows: int) -> Table:
        """Return the terms of the best individuals: as many individuals and terms as fit."""
        best = snapshot.top[:BEST_SHOWN]
        lines = {"score": [*(one.score for one in best), self._row.get("mean", math.nan)]}
        for name in best[0].terms:
            mean = self._row.get(MEAN + name, math.nan)
            lines[name] = [*(one.terms[name] for one in best), mean]
        cells = {name: [number(value) for value in values] for name, values in lines.items()}
        cell = max(VALUE, *(len(text) for texts in cells.values() for text in texts))
        fit = (width - max(map(len, cells))) // (cell + 2) - 1
        shown = min(max(fit, 1), len(best))
        columns = [*(f"#{rank + 1}" for rank in range(shown)), "mean"]
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("", no_wrap=True, overflow="ellipsis")
        for name in columns:
            table.add_column(name, justify="right", no_wrap=True, min_width=cell)
        hidden = len(cells) - max(rows, 3)
        names = [*cells][: -hidden - 1] if hidden > 0 else [*cells]
        for name in names:
            style = "bold" if name == "score" else ""
            table.add_row(Text(name), *cells[name][:shown], cells[name][-1], style=style)
        if hidden > 0:
            table.add_row(f"… and {hidden + 1} more")
        return table


def _last(rows: Rows) -> Row:
    return {name: float(values[-1]) for name, values in rows.items()}


def _format_duration(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))


def display(path: Path, known: Snapshot, json: bool) -> Display:
    """Return the display that suits the output: JSON lines, a terminal or a log."""
    if json:
        return JsonLines(path, known)
    if output().is_terminal:
        return LiveView(path, known)
    return PlainLines(path, known)


def row_of(generation: Generation, snapshot: Snapshot) -> Row:
    """Return a generation's row of the history, with the best score of each island, if any."""
    islands = list(snapshot.islands)
    return {**row(generation), **({"islands": islands} if islands else {})}


class JsonLines(Display):
    """One object per generation, with the columns of the history, and one per new stage.

    With islands, the objects also hold the best score of each.
    """

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print the number of the stage, its first generation and its changes."""
        print_json({"stage": number, "first": first, "changes": list(changes)})

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print the rows."""
        for one in rows:
            print_json(one)


class PlainLines(Display):
    """Plain lines for pipes and logs: the first, the last, and one every two seconds."""

    def __init__(
        self, path: Path, known: Snapshot, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(path, known)
        self._clock = clock
        self._printed, self._reported = -math.inf, clock()
        self._row: Row = {}
        echo(f"run {path}")

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print a line."""
        echo(stage_line(number, first, changes))

    def scored(self, share: float) -> None:
        """Print a line about a generation that takes a while."""
        now, known = self._clock(), self._snapshot
        if share < 0.995 and now - self._reported > LINE_EVERY:
            self._reported = now
            echo(f"generation {known.generation + 1}/{known.generations}  {percent(share)} scored")

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print a line if two seconds have passed or the run has ended."""
        self._snapshot = snapshot
        self._reported = now = self._clock()
        self._row = rows[-1] if rows else self._row
        if self._row and (snapshot.ended or now - self._printed > 2):
            self._printed, values = now, self._row
            bests = snapshot.islands
            more = "  islands " + " ".join(f"{b:.4f}" for b in bests) if bests else ""
            echo(
                f"generation {values['generation']}/{snapshot.generations}  "
                f"best {values['best']:.4f}  mean {values['mean']:.4f}  "
                f"diversity {values['diversity']:.3f}{more}",
            )
            self._row = {}
