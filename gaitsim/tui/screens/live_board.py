"""Panels of the live screen: status, curves, the champion, terms and events."""

import asyncio
import math
import time
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import numpy as np
from rich.cells import cell_len, set_cell_size
from rich.style import Style
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.color import Color
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Best, Event, Snapshot
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import duration, number, percent, visible_lines
from gaitsim.storage.files.history import FIGURE, MEAN
from gaitsim.storage.growing import HistoryBuffer
from gaitsim.tui.formatting import clip
from gaitsim.tui.screens.live_source import ChampionSimulator, LiveState
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves, Series
from gaitsim.tui.widgets.lines import Lines

FPS = 12  # ticks per second
STATUS, NEWS, BODY = 4, 12, 3  # ticks between two updates of each while the run evolves
CHAMPION_EVERY = 1.0  # seconds between two simulations of a champion
COLOURS = {
    "preparing": "secondary", "queued": "secondary", "running": "success", "paused": "warning",
    "finished": "primary", "stopped": "secondary", "stopping": "warning", "failed": "error",
    "elsewhere": "secondary", "best": "success", "kept": "primary", "stage": "warning",
    "warning": "error", "spark": "primary", "spark-score": "success",
}  # fmt: skip
Styles = dict[str, Style]  # styles of the theme by state, event or part

MARKS = {
    "preparing": "◌",
    "queued": "◌",
    "running": "●",
    "paused": "‖",
    "finished": "✓",
    "stopped": "■",
    "failed": "✗",
    "elsewhere": "◉",
    "stopping": "■",
}
WORDS = {"elsewhere": "running in another program"}
HINTS = {
    "queued": "The run starts when an earlier run ends or is paused.",
    "paused": "space: resume · n: evolve one generation · c: change options · f: fork",
    "stopping": "The run stops after this generation · s: stop immediately",
    "stopped": "space: resume · c: change options · g: set the number of generations",
    "elsewhere": "Another program evolves this run, so you can only watch it · f: fork",
}
EVENT_MARKS = {"best": "★", "kept": "⚑", "stage": "▶", "warning": "!"}
TITLES = (
    "best of each generation, on its own scale",
    "best of each generation",
    "trend, own scale",
    "trend",
)  # of the curve column, the longest that fits
VALUE = 9  # columns of a number
NAME = 12
LEAST_SPARK = 8
WIDEST_SPARK = 60
LEAST_BAR = 6
LABELLED = 24  # minimum columns of an event with a label before its generation


class Board(Vertical):
    """The panels of the live screen.

    Only changes are drawn, at a limited rate, and nothing while another screen is in front.

    Args:
        run: folder of the run.
        clock: function that returns the time in seconds, for the body and its champions.

    Attributes:
        live: snapshot, history and events of the run.
        curves: curves of the best score and the mean.
        canvas: canvas of the champion.
    """

    def __init__(self, run: Path, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(id="live-board")
        self._clock = clock
        self.curves = Curves(message="loading …", id="live-curves")
        self.canvas = BodyCanvas(message="loading …", clock=clock)
        self._status, self._champion = Lines(id="live-status"), Lines(id="live-champion")
        self._table, self._log = Lines(id="live-table"), Lines(id="live-events")
        self._problem = Static(id="live-problem")
        self.live = LiveState()
        self._state = "stopped"
        self._ticks = 0
        self._stale = True
        self._since = clock()  # time at which the state began
        self._seconds = 0  # time in this state, as last drawn
        self._widths = (0, 0, 0, 0)  # of the panels as last drawn; 0 redraws all
        self._styles: Styles = {}
        self._simulator = ChampionSimulator(run)
        self._shown: Best | None = None
        self._simulating = False
        self._simulated = -CHAMPION_EVERY

    def compose(self) -> ComposeResult:
        yield self._status
        yield self._problem
        with Horizontal(id="live-top"):
            yield self.curves
            with Vertical(id="live-body"):
                yield self.canvas
                yield self._champion
        with Horizontal(id="live-bottom"):
            with VerticalScroll(id="live-terms"):
                yield self._table
            yield self._log

    def on_mount(self) -> None:
        self.canvas.playing = True
        self._then = self._clock()
        self.set_interval(1 / FPS, self._tick)

    def _tick(self) -> None:
        """Draw the changes, at a limited rate while the run evolves.

        Drawing takes time from the search, which uses all cores: a body on a third of the screen
        takes 15 ms through Textual. The ground, which is most of a picture, is drawn only with
        the focus.
        """
        now = self._clock()
        if self.screen is not self.app.screen:
            self._then = now
            return
        self._ticks += 1
        self._show_champion()
        canvas, fast = self.canvas, self.state == "running"
        if canvas.playing is fast:
            canvas.playing = not fast
        canvas.ground = not fast or canvas.has_focus
        moves = fast and canvas.duration > 0 and not self._ticks % BODY
        if moves or not fast:
            elapsed, self._then = now - self._then, now
            if moves:
                canvas.seconds = (canvas.seconds + elapsed * canvas.speed) % canvas.duration
        if not fast or not self._ticks % STATUS:
            self._draw(all_of_it=not fast or not self._ticks % NEWS)

    @property
    def state(self) -> str:
        """The state of the run, as the status line shows it."""
        return self._state

    @state.setter
    def state(self, state: str) -> None:
        if state != self._state:
            self._state, self._since = state, self._clock()

    def schedule_redraw(self) -> None:
        """Schedule a redraw."""
        self._stale = True

    def notify_style_update(self) -> None:
        super().notify_style_update()
        self._styles, self._widths = {}, (0, 0, 0, 0)

    def show_problem(self, error: GaitsimError | None) -> None:
        """Show an error; None hides it."""
        self._problem.set_class(error is not None, "shown")
        self._problem.update(Text(visible_lines(str(error))) if error else "")

    def _draw(self, *, all_of_it: bool) -> None:
        """Draw the changes in the status line, or in all panels."""
        seconds = int(self._clock() - self._since) if self.state == "preparing" else 0
        if seconds != self._seconds:
            self._stale, self._seconds = True, seconds
        table, log, width = self._table, self._log, self._status.content_size.width
        widths = width, table.size.width, *log.size
        if not width or (not self._stale and widths == self._widths):
            return
        all_of_it = all_of_it or widths != self._widths
        styles = self._styles = self._styles or self._theme()
        live, snapshot = self.live, self.live.snapshot
        hint = state_hint(snapshot, self.state, self._seconds)
        if hint or not live.events:
            line = Text(hint, styles["dim"], no_wrap=True, end="")
        else:
            line = event_line(live.events[-1], width, styles)
        self._status.show([status_line(snapshot, self.state, width, styles), line])
        if not all_of_it:
            return
        self._stale, self._widths = False, widths
        table.show(term_table(snapshot, live.course, table.size.width, styles))
        latest = islice(reversed(live.events), log.size.height)
        log.show([event_line(event, log.size.width, styles) for event in latest])
        self._curves()

    def _curves(self) -> None:
        """Draw the scores; scores of earlier stages are faint if they are not comparable."""
        course, first = self.live.course, self.live.snapshot.scored_from
        if not len(course):
            self.curves.set_series([], message="no generation is finished yet")
            return
        now = first - 1 if len(course) >= first else 0
        x, stages = course["generation"], course["stage"]
        begins = np.flatnonzero(np.diff(stages) > 0) + 1
        series = [Series(name, x[now:], course[name][now:]) for name in ("best", "mean")]
        if now:
            before = tuple(begins[begins < now].tolist())
            name = "best of earlier stages, on its own scale"
            series.append(Series(name, x[:now], course["best"][:now], before, incomparable=True))
        self.curves.set_series(series, x[begins].tolist(), y_label="score")

    def _show_champion(self) -> None:
        """Simulate the newest champion in a thread, if it is due."""
        best, now = self.live.snapshot.champion, self._clock()
        if (
            best is None
            and not self._simulating
            and self.live.known
            and self.canvas.skeleton is None
        ):
            self.canvas.set_skeleton(None, "no champion yet")
        if best is None or best == self._shown or self._simulating:
            return
        if now - self._simulated < CHAMPION_EVERY:
            return
        self._simulating, self._simulated = True, now
        self._simulate(best, self.live.snapshot.stage)

    @work(group="champion")
    async def _simulate(self, best: Best, stage: int) -> None:
        try:
            self.canvas.set_skeleton(await asyncio.to_thread(self._simulator.simulate, best, stage))
        except GaitsimError as error:
            self.canvas.set_skeleton(None, str(error))
        self._shown, self._simulating = best, False
        # The score comes first because a narrow pane cuts the end.
        text = f"score {number(best.score, 4)}, champion of gen. {best.generation:,}"
        self._champion.show([Text(text, end="", no_wrap=True)])

    def _theme(self) -> Styles:
        variables = self.app.theme_variables
        styles = {
            name: Style(color=Color.parse(variables[colour]).rich_color)
            for name, colour in COLOURS.items()
        }
        return styles | {"dim": Style(dim=True)}


def status_line(snapshot: Snapshot, state: str, width: int, styles: Styles) -> Text:
    """Return the state, generation, speed and remaining time on one line."""
    line = Text(no_wrap=True, end="")
    line.append(f"{MARKS[state]} {WORDS.get(state, state)}", styles[state])
    numbers = f"{snapshot.generation:,}/{snapshot.generations:,}"
    rest = Text()
    if snapshot.evaluations_per_second > 0:
        speed = f"{snapshot.evaluations_per_second:,.0f}"
        rest.append(f"  {speed} evaluation{'s' * (speed != '1')}/s")
    if snapshot.scored > 0 and not snapshot.ended:
        rest.append(f"  {percent(snapshot.scored)} of the next scored")
    left = snapshot.seconds_left
    if left is not None and not snapshot.ended:
        rest.append(f"  {duration(left)} left")
    if snapshot.stage > 1:
        rest.append(f"  stage {snapshot.stage}", styles["stage"])
    for label in ("  generation ", "  "):  # a label only if the bar fits too
        room = width - line.cell_len - len(label + numbers) - rest.cell_len - 2
        if room >= LEAST_BAR:
            break
    line.append(label + numbers)
    if room >= LEAST_BAR and snapshot.generations:
        full = round(min(snapshot.generation / snapshot.generations, 1.0) * room)
        line.append("  ").append("━" * full, styles[state]).append(
            "─" * (room - full), styles["dim"]
        )
    line.append_text(rest)
    line.truncate(width, overflow="ellipsis")
    return line


def state_hint(snapshot: Snapshot, state: str, seconds: int = 0) -> str:
    """Return a hint for a state that has lasted `seconds`; '' while the run evolves."""
    if state == "preparing":
        passed = f"{seconds} s" if seconds < 60 else duration(seconds)
        return f"Preparing for {passed}; the first run of a body compiles its kernels …"
    if state == "finished":
        return f"{snapshot.reason} · g: more generations · r: replay · e: export"
    return HINTS.get(state, "")


def event_line(event: Event, width: int, styles: Styles) -> Text:
    """Return an event on one line."""
    line = Text(no_wrap=True, end="")
    label = "gen. " if width >= LABELLED else " "
    line.append(f"{label}{event.generation:>5,} ", styles["dim"])
    line.append(f"{EVENT_MARKS[event.kind]} ", styles[event.kind])
    text = event.text
    if event.kind == "best":
        text = f"best score {text.replace('-', '−')}"
    elif event.kind == "kept":
        text = "saved as a champion"
    line.append(clip(text, max(width - line.cell_len, 1)))
    return line


def term_table(snapshot: Snapshot, course: HistoryBuffer, width: int, styles: Styles) -> list[Text]:
    """Return the score, terms, diversity and the search's figures, one per line.

    Each line has a curve of the best of each generation, then numbers of the last generation:
    the mean, and as many of the best individuals as fit.
    """
    terms = list(snapshot.top[0].terms) if snapshot.top else course.terms
    names = ["diversity", *terms, *course.figures]
    name = min(max(map(cell_len, names)), max(NAME, width // 6))
    fit = (width - name - LEAST_SPARK - 2) // VALUE - 1
    top = snapshot.top[: max(fit, 0)]
    room = min(max(width - name - 2 - (1 + len(top)) * VALUE, 0), WIDEST_SPARK)
    title = next((title for title in TITLES if len(title) <= room), "")
    head = Text(" " * name + " " + _left(title, room), no_wrap=True, end="")
    for title in ("mean", *(f"#{rank + 1}" for rank in range(len(top)))):
        head.append(title.rjust(VALUE))
    head.stylize(styles["dim"])
    rows = [("score", "best", "mean", [one.score for one in top])]
    rows += [
        (term, term, MEAN + term, [one.terms.get(term, math.nan) for one in top]) for term in terms
    ]
    rows += [("diversity", "diversity", "diversity", [])]
    rows += [(figure, FIGURE + figure, FIGURE + figure, []) for figure in course.figures]
    lines, scored_from = [head], snapshot.scored_from
    for label, column, mean, values in rows:
        first = scored_from - 1 if len(course) >= scored_from else 0
        curve = sparkline(course[column][first:], room) if column in course else ""
        score = label == "score" and column == "best"
        line = Text(_left(label, name) + " ", Style(bold=score), no_wrap=True, end="")
        line.append(curve.ljust(room), styles["spark-score" if score else "spark"])
        for value in (_last(course, mean), *values):
            line.append((number(value) if math.isfinite(value) else "–").rjust(VALUE))
        lines.append(line)
    return island_lines(snapshot, width, styles) + lines


def island_lines(snapshot: Snapshot, width: int, styles: Styles) -> list[Text]:
    """Return the best score of each island in the last generation; [] for one population."""
    bests = snapshot.islands
    if not bests:
        return []
    head = "best of each island"
    beside = width >= len(head) + VALUE
    most = max(filter(math.isfinite, bests), default=0.0)
    fit = max((width - len(head) * beside) // VALUE, 1)
    lines = [] if beside else [Text(head, styles["dim"], no_wrap=True, end="")]
    for first in range(0, len(bests), fit):
        line = Text(no_wrap=True, end="")
        if beside:
            line.append((head if first == 0 else "").ljust(len(head)), styles["dim"])
        for best in bests[first : first + fit]:
            text = number(best) if math.isfinite(best) else "–"
            line.append(text.rjust(VALUE), styles["spark-score"] if best == most else "")
        lines.append(line)
    return lines


def _left(text: str, width: int) -> str:
    return set_cell_size(clip(text, width), width) if width > 0 else ""


def _last(course: HistoryBuffer, name: str) -> float:
    return float(course[name][-1]) if name in course and len(course) else math.nan
