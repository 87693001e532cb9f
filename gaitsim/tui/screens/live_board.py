"""Panels of the live screen: curves, the champion, terms and events."""

import asyncio
import time
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import cast

import numpy as np
from rich.style import Style
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.color import Color
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Best
from gaitsim.render.terminal.text import number, visible_lines
from gaitsim.tui.screens import live_formatting as formatting
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.live_source import ChampionSimulator, LiveState
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves, Series
from gaitsim.tui.widgets.lines import Lines

FPS = 12  # ticks per second
STATUS, NEWS, BODY = 4, 12, 2  # ticks between two updates of each while the run evolves
RATE = 12_000  # bytes per second to the terminal while the run evolves; above it, the body waits
CHAMPION_EVERY = 1.0  # seconds between two simulations of a champion
COLOURS = {
    "preparing": "secondary", "queued": "secondary", "running": "success", "paused": "warning",
    "finished": "primary", "stopped": "secondary", "stopping": "warning", "failed": "error",
    "elsewhere": "secondary", "best": "success", "kept": "primary", "stage": "warning",
    "warning": "error", "spark": "primary", "spark-score": "success",
}  # fmt: skip


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
        self._room = self._sent = 0.0  # bytes that may be sent now, and bytes sent so far
        self._stale = True
        self._since = clock()  # time at which the state began
        self._seconds = 0  # time in this state, as last drawn
        self._widths = (0, 0, 0, 0)  # of the panels as last drawn; 0 redraws all
        self._styles: formatting.Styles = {}
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
        takes 15 ms through Textual. Each picture is also sent to the terminal, often over SSH, so
        larger ones are drawn less often. The ground, which is most of a picture, is drawn only
        with the focus.
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
        sent = cast(GaitScreen, self.screen).gaitsim.mirror.sent
        self._room, self._sent = min(self._room + RATE / FPS + self._sent - sent, RATE / 2), sent
        moves = fast and canvas.duration > 0 and self._room > 0 and not self._ticks % BODY
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
        hint = formatting.hint(snapshot, self.state, self._seconds)
        if hint or not live.events:
            line = Text(hint, styles["dim"], no_wrap=True, end="")
        else:
            line = formatting.event_line(live.events[-1], width, styles)
        self._status.show([formatting.status(snapshot, self.state, width, styles), line])
        if not all_of_it:
            return
        self._stale, self._widths = False, widths
        table.show(formatting.table(snapshot, live.course, table.size.width, styles))
        latest = islice(reversed(live.events), log.size.height)
        log.show([formatting.event_line(event, log.size.width, styles) for event in latest])
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
        text = f"champion of gen. {best.generation:,}: score {number(best.score, 4)}"
        self._champion.show([Text(text, end="", no_wrap=True)])

    def _theme(self) -> formatting.Styles:
        variables = self.app.theme_variables
        styles = {
            name: Style(color=Color.parse(variables[colour]).rich_color)
            for name, colour in COLOURS.items()
        }
        return styles | {"dim": Style(dim=True)}
