"""What a user sees while a run evolves: live, in plain lines, or as JSON lines."""

import math
import time
from collections import deque
from collections.abc import Callable
from datetime import timedelta
from typing import Self

import numpy as np
from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.constrain import Constrain
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from gaitsim.cli.console import echo, notice, output, print_json
from gaitsim.evolution import Generation
from gaitsim.render.terminal.sparkline import sparkline
from gaitsim.render.terminal.text import number, visible
from gaitsim.runs.files.history import MEAN, island_bests, row
from gaitsim.runs.writer import RunWriter

COURSES = {"best": "green", "mean": "cyan", "diversity": "magenta"}
SCORES = ("best", "mean")  # of them, the courses on the scale of the scores
BEST_SHOWN = 5
WIDEST = 100  # characters; a longer line of sight helps no one
VALUE = 7  # characters that most numbers fit in
HEIGHT_ABOVE_TERMS = 8  # lines, the table's header and the cursor's line counted
STOPPING = "Stopping after this generation; again to stop at once."


class Display:
    """A context manager that follows a run; by default there is nothing to begin or end."""

    def __init__(self, writer: RunWriter) -> None:
        self._total = writer.experiment.evolution.generations
        self._islands = writer.experiment.islands.number

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def begin_stage(self, writer: RunWriter) -> None:
        """Report that a stage begins with the next generation, its population evaluated already."""

    def update(self, generation: Generation) -> None:
        """Show a finished generation."""

    def stopping(self) -> None:
        """Report that the run stops after this generation; called by a signal's handler."""
        notice(STOPPING)


def _stage_line(writer: RunWriter) -> str:
    first = writer.last.number + 1 if writer.last else 1
    what = "; ".join(map(str, writer.changes))
    return f"stage {writer.stage} from generation {first} on: {what}"


def display(writer: RunWriter, json: bool) -> Display:
    """The display that fits where the output goes."""
    if json:
        return JsonLines(writer)
    if output().is_terminal:
        return LiveView(writer)
    return PlainLines(writer)


class JsonLines(Display):
    """One object a generation: the columns of the history; and one where a stage begins.

    With islands, the best score of each as well.
    """

    def begin_stage(self, writer: RunWriter) -> None:
        """Print the stage's number, its first generation, and what it changes."""
        first = writer.last.number + 1 if writer.last else 1
        changes = [str(change) for change in writer.changes]
        print_json({"stage": writer.stage, "first": first, "changes": changes})

    def update(self, generation: Generation) -> None:
        """Print the generation's row."""
        bests = island_bests(generation, self._islands).tolist()
        print_json({**row(generation), **({"islands": bests} if len(bests) > 1 else {})})


class PlainLines(Display):
    """A line now and then, for pipes and logs: first, last, and every two seconds."""

    def __init__(self, writer: RunWriter, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(writer)
        self._clock = clock
        self._printed = -math.inf
        echo(f"run {writer.path}")

    def begin_stage(self, writer: RunWriter) -> None:
        """Print a line."""
        echo(_stage_line(writer))

    def update(self, generation: Generation) -> None:
        """Print a line if it is time."""
        now = self._clock()
        if generation.stop or now - self._printed > 2:
            self._printed = now
            values = row(generation)
            bests = island_bests(generation, self._islands).tolist()
            more = "  islands " + " ".join(f"{b:.4f}" for b in bests) if len(bests) > 1 else ""
            echo(
                f"generation {generation.number}/{self._total}  best {values['best']:.4f}  "
                f"mean {values['mean']:.4f}  diversity {values['diversity']:.3f}{more}",
            )


class LiveView(Display):
    """Progress, the courses of best, mean and diversity, and the best individuals' terms.

    Terms stand below one another, as in a sum: any number of them with any names fits a
    narrow terminal, where only fewer individuals are shown.

    Args:
        writer: the run.
        console: where to show it; standard output by default.
        clock: seconds from any beginning.
    """

    def __init__(
        self,
        writer: RunWriter,
        console: Console | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(writer)
        self._name = visible(writer.path.name)
        self._generation = writer.last
        self._row = row(writer.last) if writer.last else {}
        history = writer.run.history if writer.last else {}
        # Scores of another fitness or body would stand on another scale.
        first = writer.run.comparable - 1 if history else 0
        self._courses = {
            name: [*history.get(name, [])[first if name in SCORES else 0 :]] for name in COURSES
        }
        self._clock = clock
        # When each of the latest generations ended: how fast it goes now, not on average.
        self._ends = deque([(clock(), self._done)], maxlen=1000)
        self._begun = clock()
        self._note = ""
        self._ended = False
        self._console = console or output()
        self._live = Live(self, console=self._console, refresh_per_second=8)

    def __enter__(self) -> Self:
        self._begun = self._clock()
        self._ends[0] = (self._begun, self._done)
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._live.stop()

    def begin_stage(self, writer: RunWriter) -> None:
        """Print a line that stays; scores of another scale begin their courses anew."""
        self._console.print(_stage_line(writer), style="bold")
        if writer.last is not None and any(change.reevaluates for change in writer.changes):
            self._generation, self._row = writer.last, row(writer.last)
            for name in SCORES:
                self._courses[name] = [self._row[name]]

    def update(self, generation: Generation) -> None:
        """Take note; the screen follows eight times a second, whatever the search's speed."""
        self._row = row(generation)
        for name, course in self._courses.items():
            course.append(self._row[name])
        self._ends.append((self._clock(), generation.number))
        self._generation = generation  # last: the screen is drawn by another thread

    def stopping(self) -> None:
        """Say so in the view: printed beside it, the next refresh would overwrite it."""
        self._note = STOPPING

    @property
    def _done(self) -> int:
        return self._generation.number if self._generation else 0

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width = min(options.max_width, WIDEST)
        parts: list[RenderableType] = [self._head(width)]
        if self._generation is not None:
            parts.append(self._curves(width))
            if self._islands > 1:
                parts.append(self._bests(self._generation))
            parts.append(self._foot(self._generation))
            # At the end, the summary tells of the champion.
            if not (self._ended and self._generation.stop):
                rows = (options.height or console.height) - HEIGHT_ABOVE_TERMS
                rows -= self._islands > 1
                parts += ["", self._terms(self._generation, width, rows)]
        yield Constrain(Group(*parts), width)

    def _head(self, width: int) -> Table:
        head = Table.grid(padding=(0, 1), expand=True)
        head.add_column(no_wrap=True, overflow="ellipsis", max_width=width // 3)
        head.add_column(ratio=1)
        head.add_column(no_wrap=True)
        head.add_column(no_wrap=True)
        bar = ProgressBar(total=self._total, completed=self._done)
        name = Text(self._name, style="bold")
        head.add_row(name, bar, f"{self._done:,}/{self._total:,}", self._time())
        return head

    def _time(self) -> str:
        if self._ended:
            return f"in {_clock_face(self._clock() - self._begun)}"
        speed = self._speed()
        return f"{_clock_face((self._total - self._done) / speed)} left" if speed else ""

    def _speed(self) -> float:
        """Generations a second, 0 where none is finished yet."""
        (start, first), (end, last) = self._ends[0], self._ends[-1]
        return (last - first) / (end - start) if end > start else 0.0

    def _curves(self, width: int) -> Table:
        curves = Table.grid(padding=(0, 1))
        curves.add_column()
        curves.add_column(justify="right", min_width=VALUE, no_wrap=True)
        curves.add_column(no_wrap=True)
        for name, colour in COURSES.items():
            course = self._courses[name]
            room = width - max(map(len, COURSES)) - max(len(number(course[-1])), VALUE) - 2
            curve = Text(sparkline(course, max(room, 1)), style=colour)
            curves.add_row(name, number(course[-1]), curve)
        return curves

    def _bests(self, generation: Generation) -> Text:
        """The best score of each island in a line, the best of them in bold."""
        bests = island_bests(generation, self._islands)
        line = Text("islands  ", no_wrap=True, overflow="ellipsis")
        for best in bests.tolist():
            line.append(
                f" {number(best):>{VALUE}}", style="bold green" if best == bests.max() else ""
            )
        return line

    def _foot(self, generation: Generation) -> Text:
        foot = Text(style="dim", no_wrap=True, overflow="ellipsis")
        if self._note and not self._ended:
            return foot.append(self._note, style="not dim yellow")
        rate = self._speed() * len(generation.genomes)
        if rate:
            foot.append(f"{rate:,.0f} evaluations/s, ")
        if generation.progress.stagnation >= 0:  # else: only judged anew
            best = generation.number - generation.progress.stagnation
            foot.append(f"best of generation {best:,}")
        if generation.progress.stage > 1:
            foot.append(f", stage {generation.progress.stage}" if foot else "")
        return foot

    def _terms(self, generation: Generation, width: int, rows: int) -> Table:
        """The sum of each of the best, as many of them and of their terms as there is room for."""
        best = np.argsort(-generation.scores, kind="stable")[:BEST_SHOWN]
        lines = {"score": (generation.scores, self._row["mean"])}
        for name, values in generation.evaluation.terms.items():
            lines[name] = (values, self._row[MEAN + name])
        cells = {
            name: [number(float(value)) for value in (*values[best], mean)]
            for name, (values, mean) in lines.items()
        }
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


def _clock_face(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))
