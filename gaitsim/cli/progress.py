"""What a user sees while a run evolves: live, in plain lines, or as JSON lines."""

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

from gaitsim.cli.console import echo, notice, output, print_json
from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment
from gaitsim.live.protocol import Best, Snapshot, ranked
from gaitsim.render.terminal.sparkline import sparkline
from gaitsim.render.terminal.text import number, visible
from gaitsim.runs.files.history import MEAN, island_bests, row
from gaitsim.runs.follow import Rows

Row = Mapping[str, Any]
"""A generation's row of the history."""

COURSES = {"best": "green", "mean": "cyan", "diversity": "magenta"}
SCORES = ("best", "mean")  # of them, the courses on the scale of the scores
BEST_SHOWN = 5
WIDEST = 100  # characters; a longer line of sight helps no one
VALUE = 7  # characters that most numbers fit in
HEIGHT_ABOVE_TERMS = 8  # lines, the table's header and the cursor's line counted
RESTING = {
    "preparing": "Preparing: the first run of a body compiles its kernels …",
    "queued": "Queued: it evolves when one of the runs before it ends.",
    "paused": "Paused.",
}
STOPPING = "Stopping after this generation; again to stop at once."


class Display:
    """A context manager that follows a run; by default there is nothing to begin or end.

    Args:
        path: the run's folder.
        known: the run as it is, with all rows of its history.
    """

    def __init__(self, path: Path, known: Snapshot) -> None:
        self._path, self._snapshot = path, known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def begin_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Report that a stage begins.

        Args:
            number: from 1.
            first: its first generation.
            changes: what it changes.
            rescored: the last generation and its row under other scores; None where the stage
                keeps the scores.
        """

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Show the state of a run, and the generations that were finished."""

    def warn(self, text: str) -> None:
        """Show a message that stays."""
        notice(text)

    def stopping(self) -> None:
        """Report that the run stops after this generation; called by a signal's handler."""
        notice(STOPPING)


def _stage_line(number: int, first: int, changes: Sequence[str]) -> str:
    return f"stage {number} from generation {first} on: {'; '.join(changes)}"


def display(path: Path, known: Snapshot, json: bool) -> Display:
    """The display that fits where the output goes."""
    if json:
        return JsonLines(path, known)
    if output().is_terminal:
        return LiveView(path, known)
    return PlainLines(path, known)


def snapshot_of(generation: Generation | None, experiment: Experiment, **more: Any) -> Snapshot:
    """Return a generation as displays take it; one without news before the first."""
    generations, islands = experiment.evolution.generations, experiment.islands.number
    if generation is None:
        return Snapshot("running", generations=generations, **more)
    progress, number = generation.progress, generation.number
    bests = tuple(island_bests(generation, islands).tolist()) if islands > 1 else ()
    found = number - progress.stagnation
    return Snapshot(
        "finished" if generation.stop else "running",
        reason=generation.stop,
        generation=number,
        generations=generations,
        stage=progress.stage,
        evaluations=progress.evaluations,
        top=ranked(generation.scores, generation.evaluation.terms, BEST_SHOWN),
        islands=bests,
        # Where the generation is only judged anew, there is none yet.
        champion=Best(found, progress.best_score, ()) if progress.stagnation >= 0 else None,
        **more,
    )


def row_of(generation: Generation, snapshot: Snapshot) -> Row:
    """Return a generation's row of the history; with islands, the best score of each as well."""
    islands = list(snapshot.islands)
    return {**row(generation), **({"islands": islands} if islands else {})}


class JsonLines(Display):
    """One object a generation: the columns of the history; and one where a stage begins.

    With islands, the best score of each as well.
    """

    def begin_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print the stage's number, its first generation, and what it changes."""
        print_json({"stage": number, "first": first, "changes": list(changes)})

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print the rows."""
        for one in rows:
            print_json(one)


class PlainLines(Display):
    """A line now and then, for pipes and logs: first, last, and every two seconds."""

    def __init__(
        self, path: Path, known: Snapshot, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(path, known)
        self._clock = clock
        self._printed = -math.inf
        self._row: Row = {}
        echo(f"run {path}")

    def begin_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print a line."""
        echo(_stage_line(number, first, changes))

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print a line if it is time."""
        now = self._clock()
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


class LiveView(Display):
    """Progress, the courses of best, mean and diversity, and the best individuals' terms.

    Terms stand below one another, as in a sum: any number of them with any names fits a
    narrow terminal, where only fewer individuals are shown.

    Args:
        path: the run's folder.
        known: the run as it is, with all rows of its history.
        console: where to show it; standard output by default.
        clock: seconds from any beginning.
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
        # Scores of another fitness or body would stand on another scale.
        first = known.scored_from - 1
        self._courses = {
            name: [*known.rows.get(name, [])[first if name in SCORES else 0 :]] for name in COURSES
        }
        self._clock = clock
        # When each of the latest generations ended: how fast it goes now, not on average.
        self._ends = deque([(clock(), self._done, known.evaluations)], maxlen=1000)
        self._begun = clock()
        self._stopping = False
        self._since = clock()  # the state is what it is
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

    def begin_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print a line that stays; scores of another scale begin their courses anew."""
        self._console.print(_stage_line(number, first, changes), style="bold")
        if rescored is not None:
            self._snapshot, self._row = rescored, _last(rescored.rows)
            for name in SCORES:
                self._courses[name] = [*rescored.rows.get(name, [])]

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Take note; the screen follows eight times a second, whatever the search's speed."""
        for one in rows:
            for name, course in self._courses.items():
                course.append(one[name])
        if rows:
            self._row = rows[-1]
            self._ends.append((self._clock(), snapshot.generation, snapshot.evaluations))
        if snapshot.state != self._snapshot.state:
            self._since = self._clock()
        self._snapshot = snapshot  # last: the screen is drawn by another thread

    def warn(self, text: str) -> None:
        """Print it above the view."""
        self._console.print(text, style="yellow")

    def stopping(self) -> None:
        """Say so in the view: printed beside it, the next refresh would overwrite it."""
        self._stopping = True

    @property
    def _done(self) -> int:
        return self._snapshot.generation

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width = min(options.max_width, WIDEST)
        parts: list[RenderableType] = [self._head(width)]
        snapshot = self._snapshot
        if snapshot.top:
            parts.append(self._curves(width))
            if snapshot.islands:
                parts.append(self._bests(snapshot.islands))
            parts.append(self._foot(snapshot))
            # At the end, the summary tells of the champion.
            if not (self._ended and snapshot.state == "finished"):
                rows = (options.height or console.height) - HEIGHT_ABOVE_TERMS
                rows -= bool(snapshot.islands)
                parts += ["", self._terms(snapshot, width, rows)]
        elif self._note() and not self._ended:
            parts.append(self._foot(snapshot))
        yield Constrain(Group(*parts), width)

    def _head(self, width: int) -> Table:
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
            return f"in {_clock_face(self._clock() - self._begun)}"
        speed, _ = self._speed()
        left = self._snapshot.generations - self._done
        return f"{_clock_face(left / speed)} left" if speed else ""

    def _speed(self) -> tuple[float, float]:
        """Generations and evaluations a second, 0 where none is finished yet."""
        (start, first, before), (end, last, after) = self._ends[0], self._ends[-1]
        passed = end - start
        return ((last - first) / passed, (after - before) / passed) if passed > 0 else (0.0, 0.0)

    def _curves(self, width: int) -> Table:
        curves = Table.grid(padding=(0, 1))
        curves.add_column()
        curves.add_column(justify="right", min_width=VALUE, no_wrap=True)
        curves.add_column(no_wrap=True)
        for name, colour in COURSES.items():
            course = self._courses[name] or [math.nan]  # only judged anew
            room = width - max(map(len, COURSES)) - max(len(number(course[-1])), VALUE) - 2
            curve = Text(sparkline(course, max(room, 1)), style=colour)
            curves.add_row(name, number(course[-1]), curve)
        return curves

    def _bests(self, bests: Sequence[float]) -> Text:
        """The best score of each island in a line, the best of them in bold."""
        line = Text("islands  ", no_wrap=True, overflow="ellipsis")
        for best in bests:
            line.append(
                f" {number(best):>{VALUE}}", style="bold green" if best == max(bests) else ""
            )
        return line

    def _foot(self, snapshot: Snapshot) -> Text:
        foot = Text(style="dim", no_wrap=True, overflow="ellipsis")
        note = self._note()
        if note and not self._ended:
            return foot.append(note, style="not dim yellow")
        _, rate = self._speed()
        parts = [f"{rate:,.0f} evaluations/s"] if rate else []
        if snapshot.champion is not None:
            parts.append(f"best of generation {snapshot.champion.generation:,}")
        if snapshot.stage > 1:
            parts.append(f"stage {snapshot.stage}")
        return foot.append(", ".join(parts))

    def _note(self) -> str:
        """What the view waits for, after a second with the time that has passed; or ''."""
        if self._stopping:
            return STOPPING
        note = RESTING.get(self._snapshot.state, "")
        seconds = int(self._clock() - self._since)
        return f"{note} {_clock_face(seconds)}" if note and seconds else note

    def _terms(self, snapshot: Snapshot, width: int, rows: int) -> Table:
        """The sum of each of the best, as many of them and of their terms as there is room for."""
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
        made = Table(box=None, pad_edge=False, header_style="bold")
        made.add_column("", no_wrap=True, overflow="ellipsis")
        for name in columns:
            made.add_column(name, justify="right", no_wrap=True, min_width=cell)
        hidden = len(cells) - max(rows, 3)
        names = [*cells][: -hidden - 1] if hidden > 0 else [*cells]
        for name in names:
            style = "bold" if name == "score" else ""
            made.add_row(Text(name), *cells[name][:shown], cells[name][-1], style=style)
        if hidden > 0:
            made.add_row(f"… and {hidden + 1} more")
        return made


def _last(rows: Rows) -> Row:
    return {name: float(values[-1]) for name, values in rows.items()}


def _clock_face(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))
