"""What the live screen shows: curves, the champion, terms, events. Told anew, drawn at leisure."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.style import Style
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.color import Color
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Static

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.steering.protocol import Best
from gaitsim.tui.screens import live_words as words
from gaitsim.tui.screens.live_source import Stage, Story
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves, Series
from gaitsim.tui.widgets.lines import Lines
from gaitsim.tui.words import number

FPS = 15  # times a second that news is drawn
PANELS = ("status", "table", "log")
CHAMPION_EVERY = 1.0  # seconds between two champions that are moved to be shown
COLOURS = {
    "preparing": "secondary", "running": "success", "paused": "warning", "finished": "primary",
    "stopped": "secondary", "stopping": "warning", "failed": "error", "elsewhere": "secondary",
    "best": "success", "kept": "primary", "stage": "warning", "warning": "error",
    "spark": "primary", "spark-score": "success",
}  # fmt: skip


class Board(Vertical):
    """The panels of the live screen.

    It draws at most `FPS` times a second, only what has changed, and nothing while another
    screen is in front.

    Args:
        run: the run's folder.
        clock: seconds that pass, for the body and for how often a champion is shown.

    Attributes:
        drawn: how many times news was drawn.
    """

    def __init__(self, run: Path, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(id="live-board")
        self._run, self._clock = run, clock
        self.story = Story()
        self.state = "stopped"
        self.hint = ""
        self.drawn = 0
        self._stale, self._widths = True, (0, 0, 0)
        self._styles: words.Styles = {}
        self._stage: Stage | None = None
        self._shown: Best | None = None
        self._moving = False
        self._moved = -CHAMPION_EVERY

    def compose(self) -> ComposeResult:
        """Status, problem, curves and champion, terms and events."""
        yield Lines(id="live-status")
        yield Static(id="live-problem")
        with Horizontal(id="live-top"):
            yield Curves(message="no generation yet", id="live-curves")
            with Vertical(id="live-body"):
                yield BodyCanvas(message="no champion yet", clock=self._clock)
                yield Lines(id="live-champion")
        with Horizontal(id="live-bottom"):
            with VerticalScroll(id="live-terms"):
                yield Lines(id="live-table")
            with VerticalScroll(id="live-events"):
                yield Lines(id="live-log")

    def on_mount(self) -> None:
        """Draw now and then."""
        self.query_one(BodyCanvas).playing = True
        self.set_interval(1 / FPS, self.draw)

    def stale(self) -> None:
        """Have what is shown drawn anew soon."""
        self._stale = True

    def notify_style_update(self) -> None:
        """Take the colours of another theme."""
        super().notify_style_update()
        self._styles, self._stale = {}, True

    def problem(self, error: GaitsimError | None) -> None:
        """Show what went wrong and what to do, in its place."""
        panel = self.query_one("#live-problem", Static)
        panel.set_class(error is not None, "shown")
        panel.update(Text(str(error)) if error else "")

    def draw(self) -> None:
        """Draw what is new."""
        if self.screen is not self.app.screen:
            return
        self._show_champion()
        status, table, log = (self.query_one(f"#live-{of}", Lines) for of in PANELS)
        width = status.content_size.width
        widths = width, table.size.width, log.size.width
        if not width or (not self._stale and widths == self._widths):
            return
        self._stale, self._widths = False, widths
        self.drawn += 1
        styles = self._styles = self._styles or self._theme()
        story, snapshot = self.story, self.story.snapshot
        news = self.hint
        if not news and story.events:
            second = words.event_line(story.events[-1], width, styles)
        else:
            second = Text(news, styles["dim"], no_wrap=True, end="")
        status.show([words.status(snapshot, self.state, width, styles), second])
        scored = story.course, snapshot.scored_from
        table.show(words.table(snapshot, *scored, table.size.width, styles))
        if log.size.width:
            latest = reversed(story.events)
            log.show([words.event_line(event, log.size.width, styles) for event in latest])
        self._curves()

    def _curves(self) -> None:
        course, first = self.story.course, self.story.snapshot.scored_from
        if not len(course):
            return
        part = slice(first - 1, None) if len(course) >= first else slice(None)
        x = course["generation"][part]
        stages = course["stage"][part]
        self.query_one(Curves).set_series(
            [Series(name, x, course[name][part]) for name in ("best", "mean")],
            (x[1:][np.diff(stages) > 0]).tolist(),
        )

    def _show_champion(self) -> None:
        """Move the newest champion, in a thread, if there is one and it is time."""
        best, now = self.story.snapshot.champion, self._clock()
        if best is None or best == self._shown or self._moving:
            return
        if now - self._moved < CHAMPION_EVERY:
            return
        self._moving, self._moved = True, now
        self._move(best, self.story.snapshot.stage)

    @work(thread=True, group="champion")
    def _move(self, best: Best, stage: int) -> None:
        if self._stage is None or self._stage.number != stage:
            self._stage = Stage(self._run, stage)
        found: Skeleton | GaitsimError
        try:
            found = self._stage.move(best)
        except GaitsimError as error:
            found = error
        self.app.call_from_thread(self._take_champion, best, found)

    def _take_champion(self, best: Best, found: Skeleton | GaitsimError) -> None:
        if not self.is_attached:  # the screen was left meanwhile
            return
        self._shown, self._moving = best, False
        canvas = self.query_one(BodyCanvas)
        if isinstance(found, GaitsimError):
            canvas.set_skeleton(None, str(found))
        else:
            canvas.set_skeleton(found)
        said = f"champion of generation {best.generation:,}: {number(best.score)}"
        self.query_one("#live-champion", Lines).show([Text(said, end="", no_wrap=True)])

    def _theme(self) -> words.Styles:
        variables = self.app.theme_variables
        styles = {
            name: Style(color=Color.parse(variables[colour]).rich_color)
            for name, colour in COLOURS.items()
        }
        return styles | {"dim": Style(dim=True)}
