"""What a user sees while a run evolves: live, in plain lines, or as JSON lines."""

import time
from types import TracebackType
from typing import Protocol, Self

import numpy as np
from rich.console import Group, RenderableType
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from gaitsim.cli.console import number, output, print_json, table
from gaitsim.evolution import Generation
from gaitsim.runs.directory import RunWriter
from gaitsim.runs.history import row

BLOCKS = "▁▂▃▄▅▆▇█"
BEST_SHOWN = 5


class Display(Protocol):
    """A context manager that is told of every generation."""

    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...
    def update(self, generation: Generation) -> None:
        """Show a finished generation."""


def display(writer: RunWriter, json: bool) -> Display:
    """The display that fits where the output goes."""
    if json:
        return JsonLines()
    if output().is_terminal:
        return LiveView(writer)
    return PlainLines(writer)


class Silent:
    """A display with nothing to begin or end."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        pass


class JsonLines(Silent):
    """One object a generation: the columns of the history."""

    def update(self, generation: Generation) -> None:
        """Print the generation's row."""
        print_json(row(generation))


class PlainLines(Silent):
    """A line now and then, for pipes and logs: first, last, and every two seconds."""

    def __init__(self, writer: RunWriter) -> None:
        self._total = writer.experiment.evolution.generations
        self._printed = -1e9
        print(f"run {writer.path}", flush=True)

    def update(self, generation: Generation) -> None:
        """Print a line if it is time."""
        now = time.monotonic()
        if generation.stop or now - self._printed > 2:
            self._printed = now
            values = row(generation)
            print(
                f"generation {generation.number}/{self._total}  best {values['best']:.4f}  "
                f"mean {values['mean']:.4f}  diversity {values['diversity']:.3f}",
                flush=True,
            )


class LiveView:
    """Progress bar, sparklines of best and mean, and the best individuals with their terms."""

    def __init__(self, writer: RunWriter) -> None:
        self._progress = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[speed]}"),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        last = writer.last
        self._task = self._progress.add_task(
            writer.path.name,
            total=writer.experiment.evolution.generations,
            completed=last.number if last else 0,
            speed="",
        )
        history = writer.run.history if last else {}
        self._best = [*history.get("best", [])]
        self._mean = [*history.get("mean", [])]
        self._generation = last
        self._begun, self._done = time.monotonic(), 0
        self._live = Live(self, console=output(), refresh_per_second=8)

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._live.stop()

    def update(self, generation: Generation) -> None:
        """Take note; the screen follows eight times a second, whatever the search's speed."""
        values = row(generation)
        self._best.append(values["best"])
        self._mean.append(values["mean"])
        self._generation = generation
        self._done += len(generation.genomes)
        rate = self._done / max(time.monotonic() - self._begun, 1e-9)
        self._progress.update(
            self._task, completed=generation.number, speed=f"{rate:,.0f} evaluations/s"
        )

    def __rich__(self) -> RenderableType:
        parts: list[RenderableType] = [self._progress]
        if self._generation is not None:
            parts += [self._curves(), "", self._table(self._generation)]
        return Group(*parts)

    def _curves(self) -> Table:
        curves = Table.grid(padding=(0, 1))
        for name, values, colour in (("best", self._best, "green"), ("mean", self._mean, "cyan")):
            curves.add_row(name, Text(sparkline(values, 48), style=colour), number(values[-1]))
        return curves

    def _table(self, generation: Generation) -> Table:
        terms = generation.evaluation.terms
        columns = ("score", *terms)
        made = table("#", *columns, numbers=("#", *columns))
        for rank, index in enumerate(np.argsort(-generation.scores, kind="stable")[:BEST_SHOWN]):
            cells = [generation.scores[index], *(values[index] for values in terms.values())]
            made.add_row(str(rank + 1), *(number(float(cell)) for cell in cells))
        return made


def sparkline(values: list[float], width: int) -> str:
    """A row of blocks, one a stretch of the values' course; gaps where nothing is finite."""
    course = np.asarray(values, dtype=float)
    if len(course) > width:
        # The last value of each stretch, so that the newest one is always shown.
        course = course[np.linspace(len(course) / width - 1, len(course) - 1, width).astype(int)]
    finite = course[np.isfinite(course)]
    if not len(finite):
        return " " * len(course)
    low, high = finite.min(), finite.max()
    scale = (len(BLOCKS) - 1) / (high - low) if high > low else 0.0
    return "".join(
        BLOCKS[round((value - low) * scale)] if np.isfinite(value) else " " for value in course
    )
