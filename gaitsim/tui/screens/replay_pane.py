"""One run in the replay: its body, feet, measures, and the generation that is shown."""

import asyncio
from pathlib import Path
from typing import Any

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import number, visible, visible_lines
from gaitsim.tui.formatting import clip, clip_name
from gaitsim.tui.screens.replay_loading import Shown, load
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves, Series
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.scrubber import Scrubber

ROOMY = 110  # columns of a pane from which measures stand beside the body
WORDY = 60  # columns from which its title says what the numbers are


class ReplayPane(Vertical):
    """A body of a run, whose generation can be changed.

    Of the generations asked for while another one is being read, only the last is read after it.

    Args:
        run: its folder.
        generation: to begin with; None is the champion's.

    Attributes:
        shown: the individual; None where there is none yet, or a problem.
        generation: the one that is shown or asked for; None is the champion's.
        loading_now: whether one is being read.
    """

    DEFAULT_CSS = """
    ReplayPane {
        width: 1fr; height: 1fr;
        & > .title { height: 1; padding: 0 1; }
        & > Horizontal { height: 1fr; }
        & FootfallStrip { margin: 0 1; }
        & > Scrubber { margin: 0 1; }
        & .side { width: 34; padding: 0 1; border-left: solid $border-blurred; }
        & .side > Static { height: auto; max-height: 70%; }
        & .side > Curves { height: 1fr; min-height: 7; max-height: 14; }
    }
    """

    class Changed(Message):
        """Another body is shown, or the reason why there is none."""

    def __init__(self, run: Path, generation: int | None = None, **settings: Any) -> None:
        super().__init__(**settings)
        self.run = run
        self.shown: Shown | None = None
        self.problem: GaitsimError | None = None
        self.generation = generation
        self.loading_now = False
        self._measures: bool | None = None
        self.canvas = BodyCanvas(message="moving the body …")
        self.feet = FootfallStrip()
        self.slider = Scrubber("generation", 1, 1, 1)
        self._heading = Static(classes="title")
        self._side = Vertical(classes="side")
        self._numbers = Static(classes="measures")
        self._curve = Curves(legend=False)

    def compose(self) -> ComposeResult:
        yield self._heading
        with Horizontal():
            yield self.canvas
            with self._side:
                yield self._numbers
                yield self._curve
        yield self.feet
        yield self.slider

    def on_mount(self) -> None:
        self._side.display = False
        self._title()
        self.ask(self.generation)

    def ask(self, generation: int | None) -> None:
        """Show another generation's best as soon as it can be; None is the champion of all."""
        if self.shown is not None and generation is not None:
            generation = min(max(generation, 1), self.shown.last)
        self.generation = generation
        if generation is not None:
            self.slider.value = generation
        if not self.loading_now:
            self.loading_now = True
            self._load(generation)
        self._title()

    @work(group="replay")
    async def _load(self, asked: int | None) -> None:
        """Show a generation, then the one asked for meanwhile."""
        while self.loading_now:
            try:
                shown = await asyncio.to_thread(load, self.run, asked)
            except GaitsimError as error:
                self._fail(error)
            except Exception as error:  # shown as well, rather than ending the app
                self._fail(_unexpected(error))
            else:
                self.slider.set_range(1, shown.last)
                if self.generation == asked:
                    asked = self.generation = self.slider.value = shown.generation
                self._show(shown)
            self.loading_now = self.generation != asked
            asked = self.generation
            self._title()

    def _show(self, shown: Shown) -> None:
        self.shown, self.problem = shown, None
        self.canvas.set_skeleton(shown.individual.skeleton)
        self.feet.set_skeleton(shown.individual.skeleton)
        self.feet.frame = self.canvas.frame
        self._fill()
        self.post_message(self.Changed())

    def _fail(self, error: GaitsimError) -> None:
        self.shown, self.problem = None, error
        self.canvas.set_skeleton(None, visible_lines(str(error)))
        self.feet.set_skeleton(None)
        self._make_room()
        self.post_message(self.Changed())

    def show_frame_of(self, seconds: float) -> None:
        """Show a moment, or the last one before it."""
        self.canvas.seconds = min(seconds, self.canvas.duration)
        self.feet.frame = self.canvas.frame

    def _title(self) -> None:
        title = Text(no_wrap=True, overflow="ellipsis")
        width = max(self.size.width - 2, 12)
        title.append(clip_name(self.run.name, max(width // 3, 8)), "bold")
        shown = self.shown
        if shown is not None:
            wide = width >= WORDY
            title.append(f"  {'generation ' if wide else ''}{shown.generation}")
            title.append(f"/{shown.last}", "dim")
            title.append(" ★" if shown.generation == shown.champion else "")
            title.append(f"  {'score ' if wide else ''}{number(shown.individual.score, 4)}")
            if shown.stage[1] > 1 and wide:
                title.append(f"  stage {shown.stage[0]}/{shown.stage[1]}", "dim")
        if self.loading_now:
            wanted = "the champion" if self.generation is None else f"generation {self.generation}"
            title.append(f"  reading {wanted} …", "dim")
        self._heading.update(title)

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
        self._side.display = wanted and self.shown is not None

    def _fill(self) -> None:
        """Show measures, terms, and the generation on the curve."""
        shown = self.shown
        assert shown is not None, "something was read"
        rows = [
            (name, f"{number(one.value, 4)} {one.unit}".rstrip())
            for name, one in shown.measurements.items()
        ]
        terms = [(name, number(value, 4)) for name, value in shown.individual.terms.items()]
        text = Text(no_wrap=True, overflow="ellipsis")
        for heading, lines in (("measures", rows), ("terms of the score", terms)):
            if lines:
                text.append("\n" if text else "")
                text.append(f"{heading}\n", "bold")
            for name, value in lines:
                room = 31 - len(value)
                text.append(f"{clip(name, room - 1).ljust(room)}{visible(value)}\n")
        self._numbers.update(text)
        history = shown.history
        best = Series("best", history["generation"], history["best"])
        self._curve.set_series([best], [shown.generation])
        self._make_room()

    @on(Scrubber.Changed)
    def _scrubbed(self, event: Scrubber.Changed) -> None:
        event.stop()
        self.ask(event.value)


def _unexpected(error: Exception) -> GaitsimError:
    return GaitsimError(
        f"this could not be shown: {type(error).__name__}: {error}",
        remedy="report it to the authors of gaitsim, with what you did",
    )
