"""A run in the replay: the body, footfalls and measures of one individual."""

import asyncio
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.cells import cell_len, set_cell_size
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.message import Message
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Numbered, Which, mark_of
from gaitsim.render.terminal.text import number, visible_lines
from gaitsim.tui.formatting import clip, clip_name
from gaitsim.tui.screens.replay_loading import (
    Loader,
    ReplayView,
    curve_of,
    describe,
    last_of,
    number_of,
    with_number,
)
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.scrubber import Scrubber

ROOMY = 110  # minimum columns of a pane that shows measures by default
WORDY = 48  # minimum columns for stages and worlds in the title
NAME = 8  # minimum columns of the run's name
# Labels of the numbers in the title; the first that fit.
LABELS = (("generation ", "score "), ("gen. ", "score "), ("gen. ", ""))
BESIDE = 64  # minimum columns for measures beside the body rather than in its place
TALL, HIGH = 16, 28  # minimum rows for the curve, and for a higher curve
WIDTH = 39  # columns of the measures beside the body
UNIT = 8  # maximum columns of a unit


class ReplayPane(Vertical):
    """An individual of a run in motion, with a slider to choose a different one.

    Of several individuals requested while one is being read, only the last is read next.

    Args:
        run: folder of the run.
        which: first individual; None is the champion.
        damage: damage of the body, in the syntax of `--damage`.

    Attributes:
        shown: individual shown; None before the first one, or after a problem.
        which: individual shown or requested; None is the champion.
        loading_now: whether an individual is being read.
        numbers: scrollable list of measures and terms.
    """

    DEFAULT_CSS = """
    ReplayPane {
        width: 1fr; height: 1fr;
        & > .title { height: 1; width: 1fr; padding: 0 1; }
        &:focus-within > .title { background: $surface; }
        & > Horizontal { height: 1fr; }
        & FootfallStrip { padding: 0 1; }
        & > Scrubber { padding: 0 1; }
        & .side { width: 39; border-left: solid $border-blurred; }
        & .side > VerticalScroll { height: 1fr; padding: 0 0 0 1; }
        & .side > VerticalScroll:focus { background: $surface; }
        & .side > Curves { height: 7; padding: 0 1; }
        &.-high .side > Curves { height: 12; }
        &.-narrow .side { width: 1fr; border-left: none; }
    }
    """

    class IndividualShown(Message):
        """Posted when a new body or a problem is shown."""

    def __init__(
        self, run: Path, which: Which = None, damage: Sequence[str] = (), **settings: Any
    ) -> None:
        super().__init__(**settings)
        self.damage = tuple(damage)
        self.run = run
        self.shown: ReplayView | None = None
        self.problem: GaitsimError | None = None
        self.which = which
        self.loading_now = False
        self._measures: bool | None = None
        self._loader = Loader(run, damage=self.damage)
        self.canvas = BodyCanvas(message="reading the run …")
        self.feet = FootfallStrip()
        self.slider = Scrubber("generation", 1, 1, 1)
        self._heading = Static(classes="title")
        self._side = Vertical(classes="side")
        self.numbers = VerticalScroll()
        self._numbers = Static(classes="measures")
        self._curve = Curves()

    def compose(self) -> ComposeResult:
        yield self._heading
        with Horizontal():
            yield self.canvas
            with self._side:
                with self.numbers:
                    yield self._numbers
                yield self._curve
        yield self.feet
        yield self.slider

    def on_mount(self) -> None:
        self._side.display = False
        self._title()
        self.request(self.which)

    def request(self, which: Which) -> None:
        """Request an individual; None is the champion."""
        if self.shown is not None and which is not None:
            number = min(max(number_of(which), 1), last_of(self.shown, which))
            which = which if number == number_of(which) else with_number(which, number)
        self.which = which
        if which is not None:
            self._set_slider(which)
        self.canvas.show_message(f"reading {self._requested} …")
        if not self.loading_now:
            self.loading_now = True
            self._load(which)
        self._title()

    @work(group="replay")
    async def _load(self, requested: Which) -> None:
        """Show an individual, then the one requested in the meantime."""
        while self.loading_now:
            try:
                shown = await asyncio.to_thread(self._loader.load, requested)
            except GaitsimError as error:
                self._fail(error)
            except Exception as error:  # shown too, instead of ending the app
                self._fail(unexpected_error(error))
            else:
                self._show(shown)
                if self.which == requested:
                    requested = self.which = shown.which
                    self._set_slider(requested)
            self.loading_now = self.which != requested
            requested = self.which
            self._title()

    def _show(self, shown: ReplayView) -> None:
        self.shown, self.problem = shown, None
        self.canvas.set_skeleton(shown.individual.skeleton)
        self.feet.set_skeleton(shown.individual.skeleton)
        self.feet.frame = self.canvas.frame
        across, series, mark = curve_of(shown)
        self._curve.set_series([series], [mark], x_label=across)
        self._make_room()
        self.post_message(self.IndividualShown())

    def _set_slider(self, which: int | Member | Numbered) -> None:
        """Set the slider's range to the generations or members and its value to this one."""
        self.slider.label = "member    " if isinstance(which, Member) else "generation"
        if self.shown is not None:
            self.slider.set_range(1, last_of(self.shown, which))
        self.slider.value = number_of(which)

    def _fail(self, error: GaitsimError) -> None:
        self.shown, self.problem = None, error
        self.canvas.set_skeleton(None, visible_lines(str(error)))
        self.feet.set_skeleton(None)
        self._make_room()
        self.post_message(self.IndividualShown())

    def show_frame_of(self, seconds: float) -> None:
        """Show the frame at a time, at most that of the last frame."""
        self.canvas.seconds = min(seconds, self.canvas.duration)
        self.feet.frame = self.canvas.frame

    def _title(self) -> None:
        width = max(self.size.width - 2, 12)
        rest = Text(no_wrap=True, overflow="ellipsis")
        if self.shown is not None:
            texts = [_numbers(self.shown, *labels, wide=width >= WORDY) for labels in LABELS]
            fitting = (text for text in texts if text.cell_len <= width - NAME)
            rest.append_text(next(fitting, texts[-1]))
        if self.damage:
            rest.append(f"  {', '.join(self.damage)}", "$error")
        if self.loading_now:
            rest.append(f"  reading {self._requested} …", "dim")
        name = clip_name(self.run.name, max(width - rest.cell_len, NAME))
        self._heading.update(Text.assemble((name, "bold"), rest, no_wrap=True, overflow="ellipsis"))

    @property
    def _requested(self) -> str:
        """The requested individual in words."""
        return describe(self.which)

    def show_measures(self, wanted: bool) -> None:
        """Show or hide the measures beside the body, at any width."""
        self._measures = wanted
        self._make_room()

    @property
    def measures_shown(self) -> bool:
        """Whether measures are shown."""
        return self._side.display

    def on_resize(self) -> None:
        self._make_room()
        self._title()

    def _make_room(self) -> None:
        roomy = self.size.width >= ROOMY
        wanted = roomy if self._measures is None else self._measures
        shown = self._side.display = wanted and self.shown is not None
        narrow = self.size.width < BESIDE
        self.set_class(narrow, "-narrow")
        self.canvas.display = not (shown and narrow)
        feet = self.feet.get_content_height(self.size, self.app.size, self.size.width)
        rows = self.size.height - 2 - (feet if self.feet.display else 0)
        self._curve.display = rows >= TALL
        self.set_class(rows >= HIGH, "-high")
        self._list()

    def _list(self) -> None:
        """List the measures and terms in the available width."""
        shown = self.shown
        if shown is None:
            return
        measures = [(name, one.value, one.unit) for name, one in shown.measurements.items()]
        terms = [(name, value, "") for name, value in shown.individual.terms.items()]
        width = min(self.content_size.width, WIDTH) - 4  # border, padding, scroll bar
        text = Text(no_wrap=True, overflow="ellipsis")
        for heading, rows in (("measures", measures), ("terms of the score", terms)):
            if rows:
                text.append("\n\n" if text else "").append(heading, "bold")
                text.append("".join(f"\n{line}" for line in number_lines(rows, width)))
        self._numbers.update(text)

    @on(Scrubber.Scrubbed)
    def _scrubbed(self, event: Scrubber.Scrubbed) -> None:
        event.stop()
        self.request(with_number(self.which, event.value))


def _numbers(shown: ReplayView, generation: str, score: str, *, wide: bool) -> Text:
    """Return the number and score of an individual; if `wide`, also its worlds and stage.

    Args:
        shown: individual.
        generation: label of the number of a generation.
        score: label of the score.
        wide: whether there is room for worlds and stage.
    """
    which = shown.which
    text = Text(f"  {'member ' if isinstance(which, Member) else generation}{mark_of(which)[1:]}")
    text.append(f"/{last_of(shown, which)}", "dim")
    text.append(" ★" if which == shown.best else "")
    text.append(f"  {score}{number(shown.individual.score, 4)}")
    text.append(shown.individual.over_worlds if wide else "", "dim")
    if shown.stage[1] > 1 and wide:
        text.append(f"  stage {shown.stage[0]}/{shown.stage[1]}", "dim")
    return text


def number_lines(rows: Sequence[tuple[str, float, str]], width: int) -> Iterator[str]:
    """Yield aligned lines of a name, a number and its unit, `width` cells wide."""
    numbers = [number(value, 4) for _, value, _ in rows]
    units = [clip(unit, UNIT) for _, _, unit in rows]
    wide, unit = max(map(len, numbers)), max(map(cell_len, units))
    room = max(width - wide - unit - 2, 4)
    for (name, *_), value, after in zip(rows, numbers, units, strict=True):
        yield f"{set_cell_size(clip(name, room), room)} {value.rjust(wide)} {after}".rstrip()


def unexpected_error(error: Exception) -> GaitsimError:
    """Return the error of an individual that cannot be shown."""
    return GaitsimError(
        f"the individual cannot be shown: {type(error).__name__}: {error}",
        remedy="report it to the authors of gaitsim, with the steps that led to it",
    )
