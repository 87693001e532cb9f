"""The preview of a run at home: its champion in motion, its curve and its main figures."""

import asyncio
from collections import OrderedDict

from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import Container
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import duration, number, visible_lines
from gaitsim.storage.overview import Overview
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.screens.replay_loading import ReplayView, curve_of, load_individual
from gaitsim.tui.screens.replay_pane import number_lines, unexpected_error
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves

FPS = 7  # a spider sends up to 2 kB per frame
REST = 0.25  # seconds without a move of the cursor before a run is read
AGAIN = 5.0  # minimum seconds between two champions of the same run
KEPT = 8  # runs in memory

Key = tuple[object, ...]


class RunPreview(Container):
    """The champion of a run in motion, its curve and its main figures.

    A run is read in a thread, after the cursor has rested on it. The motion pauses while the
    terminal has lost the focus, and does not play without animations.
    """

    DEFAULT_CSS = """
    RunPreview {
        height: 13; layout: horizontal; border-top: solid $border-blurred;
        & BodyCanvas { width: 1fr; }
        & Curves { width: 1fr; padding: 0 1; }
        & .figures { width: 36; height: 1fr; padding: 0 1; }
    }
    RunPreview.-beside {
        width: 48; height: 1fr; layout: vertical;
        border-top: none; border-left: solid $border-blurred;
        & BodyCanvas { height: 1fr; }
        & Curves { height: 9; }
        & .figures { width: 1fr; height: auto; max-height: 50%; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self.canvas = BodyCanvas(message=" ", fps=FPS)
        self.curve = Curves()
        self.canvas.can_focus = self.curve.can_focus = False
        self._figures = Static(classes="figures")
        self._run: Overview | None = None
        self._shown: Key = ()  # the champion on the screen
        self._wanted: Key = ()
        self._known: OrderedDict[Key, ReplayView | GaitsimError] = OrderedDict()
        self._reading = self._due = False  # a run is being read, or will be

    def compose(self) -> ComposeResult:
        yield self.canvas
        yield self.curve
        yield self._figures

    def on_mount(self) -> None:
        """Follow the focus of the terminal."""
        self.watch(self.app, "app_focus", self._play)
        self._timer = self.set_timer(0, self._read, pause=True)

    def _play(self) -> None:
        """Play the motion, unless nobody watches or wants animations."""
        watched = self.app.app_focus and self.app.animation_level != "none"
        self.canvas.playing = watched and self.display and self.canvas.skeleton is not None

    def show(self, run: Overview | None) -> None:
        """Show a run; None shows nothing."""
        if not self.is_mounted:
            self.call_after_refresh(self.show, run)
            return
        moved = run is None or self._run is None or run.path != self._run.path
        self._run = run
        readable = run is not None and run.problem is None and run.generation > 0
        self._wanted = (run.path, run.best, run.stage) if run and readable else ()
        if moved:
            self._timer.stop()
            self._due = False
        if not self._wanted:
            self._clear(" " if run is None or run.problem else "no finished generation yet")
        elif self._wanted in self._known and self._wanted != self._shown:
            assert run is not None, "it has a champion"
            self._draw(self._wanted, run)
        elif self._wanted != self._shown:
            if moved:
                self._clear(" ")
            self._read_after(REST if moved else AGAIN)

    def _read_after(self, seconds: float) -> None:
        """Read the run under the cursor after some time, unless it will be read anyway."""
        if not self._due:
            self._due = True
            self._timer.stop()
            self._timer = self.set_timer(seconds, self._read)

    def _clear(self, message: str) -> None:
        self._shown = ()
        self.canvas.set_skeleton(None, message)
        self.curve.set_series([], message="")
        self._figures.update("")
        self._play()

    def _read(self) -> None:
        self._due = False
        if self._wanted and not self._reading:
            self._reading = True
            self._load()

    @work(group="preview")
    async def _load(self) -> None:
        """Read the run under the cursor, then the one under it in the meantime."""
        wanted: Key = ()
        while self._wanted[:1] != wanted[:1] and self._run is not None:
            wanted, run = self._wanted, self._run
            if wanted not in self._known:
                if self._shown[:1] != wanted[:1]:
                    self.canvas.show_message("reading the champion …")
                self._known[wanted] = await asyncio.to_thread(_load, run)
            if self._wanted[:1] == wanted[:1]:
                self._draw(wanted, run)
        while len(self._known) > KEPT:
            self._known.popitem(last=False)
        self._reading = False
        if self._wanted != wanted:
            self._read_after(AGAIN)

    def _draw(self, key: Key, run: Overview) -> None:
        """Show the champion that has been read."""
        found = self._known[key]
        if isinstance(found, GaitsimError):
            self._clear(visible_lines(str(found)))
            self._shown = key
            return
        self._shown = key
        self.canvas.set_skeleton(found.individual.skeleton)
        across, series, mark = curve_of(found)
        self.curve.set_series([series], [mark], x_label=across, y_label="score")
        self._figures.update(figures(run, found, self._figures.content_size.width or 34))
        self._play()


def _load(run: Overview) -> ReplayView | GaitsimError:
    """Read the champion of a run, or the reason why it cannot be read."""
    try:
        return load_individual(RunSnapshot(run.path), None)
    except GaitsimError as error:
        return error
    except Exception as error:  # of a plugin; shown, instead of ending the app
        return unexpected_error(error)


def figures(run: Overview, shown: ReplayView, width: int) -> Text:
    """Return the score, the terms and the measures of a champion, and the size of its run."""
    rows = [(name, value, "") for name, value in shown.individual.terms.items()]
    rows += [
        (name, one.value, one.unit)
        for name, one in shown.measurements.items()
        if name not in shown.individual.terms
    ]
    text = Text(no_wrap=True, overflow="ellipsis")
    text.append(f"score {number(shown.individual.score, 4)}", "bold")
    text.append(f"  generation {shown.generation:,}")
    text.append(f"\n{run.evaluations:,} evaluations in {duration(run.seconds)}", "dim")
    if rows:
        text.append("".join(f"\n{line}" for line in number_lines(rows, width)))
    return text
