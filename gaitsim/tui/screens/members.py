"""Base class of the screens of members: a plot with a cursor, and the gait under it."""

import asyncio
import time
from abc import abstractmethod
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Generic

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which
from gaitsim.render.terminal.member_picture import axis_labels
from gaitsim.render.terminal.text import number, visible, visible_lines
from gaitsim.storage.files.folder import command
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.screens.members_source import KeptMembers, MembersReader, MovingMember
from gaitsim.tui.screens.questions import Ask
from gaitsim.tui.screens.replay_loading import parse_number
from gaitsim.tui.screens.replay_pane import number_lines
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.lines import Lines
from gaitsim.tui.widgets.member_plot import MemberPlot, V

FPS = 12
BODY = 12  # minimum rows of the body if more than a FEW measures are shown
FEW = 3
REASON = 3  # maximum lines of the reason for the gait's name
LOOK = 1.0  # seconds between two checks for new generations
SHARE = 10  # minimum pause between two reads, as a multiple of the time of a read
LONGEST = 10.0  # maximum pause, seconds
PAUSE = 0.1  # seconds for which the cursor rests before a member is simulated
NEEDS_GAIT = (
    *("best", "go_to", "replay", "why", "export", "play", "view", "on_individual"),
    *("along", "mark"),
)
"""The actions that need a member under the cursor."""


class MemberPane(Vertical):
    """A member of a run in motion.

    Attributes:
        canvas: canvas of its body.
        member: the member shown; None before the first one, or if it cannot be drawn.
    """

    DEFAULT_CSS = """
    MemberPane {
        width: 4fr; height: 1fr; border-left: solid $border-blurred;
        & > Lines, & > FootfallStrip { padding: 0 1; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self.canvas = BodyCanvas(message="no gait yet", fps=FPS)
        self.member: MovingMember | None = None
        self._gait, self._measures, self._feet = Lines(), Lines(), FootfallStrip()

    def compose(self) -> ComposeResult:
        yield self._gait
        yield self.canvas
        yield self._measures
        yield self._feet

    def on_mount(self) -> None:
        self.canvas.playing = True

    def show(self, member: MovingMember) -> None:
        """Show a member."""
        if member is self.member:
            return
        self.member = member
        skeleton = member[0].individual.skeleton
        self.canvas.set_skeleton(skeleton)
        self._feet.set_skeleton(skeleton)
        self._feet.frame = self.canvas.frame
        self._list(member)

    def show_error(self, error: GaitsimError) -> None:
        """Show an error instead of the body."""
        self.member = None
        self.canvas.set_skeleton(None, visible_lines(str(error)))
        self._feet.set_skeleton(None)
        for lines in (self._gait, self._measures):
            lines.show([])

    def _list(self, member: MovingMember) -> None:
        """Show the gait's name and as many measures as fit."""
        width = max(self.content_size.width - 2, 16)
        lines = []
        shown, gait = member
        if gait is not None:
            name = "no named gait" if gait.name == "none" else gait.name
            reason = Text(visible(gait.reason), "dim", end="")
            lines = [Text(visible(name), "bold", end="")]
            lines += reason.wrap(self.app.console, width)[:REASON]
        self._gait.show(lines)
        measured = shown.measurements.items()
        rows = [(name, one.value, one.unit) for name, one in measured]
        numbers = [*number_lines(rows, width)] if rows else []
        feet = self._feet.get_content_height(self.size, self.app.size, self.size.width)
        free = self.size.height - len(lines) - feet - BODY
        kept = numbers[: max(free, FEW)]
        self._measures.show([Text(line, no_wrap=True, end="") for line in kept])

    @on(BodyCanvas.FrameShown)
    def _moved(self) -> None:
        self._feet.frame = self.canvas.frame

    def on_resize(self) -> None:
        if self.member is not None:
            self._list(self.member)


class MembersScreen(GaitScreen, Generic[V]):
    """The members of a run in a plot, with the one under the cursor in motion.

    Args:
        run: folder of the run.
        which: member initially under the cursor; the best if it is not a member.
        plot: widget that shows the members.
        reader: reader of the members.

    Attributes:
        plot: plot with the cursor.
        pane: pane of the member under the cursor.
    """

    DEFAULT_CSS = """
    MembersScreen {
        & #members-left { width: 5fr; height: 1fr; padding: 0 1; }
        & #member { height: auto; }
        & MemberPlot:focus { background-tint: $foreground 3%; }
    }
    """
    AUTO_FOCUS = "MemberPlot"

    # Determines the available keys; a change updates the footer, which is slow.
    offers: reactive[tuple[bool, int]] = reactive((False, 0), init=False, bindings=True)

    def __init__(
        self, run: Path, which: Which, plot: MemberPlot[V], reader: MembersReader[V]
    ) -> None:
        super().__init__()
        self.run, self.plot = run, plot
        self.pane = MemberPane()
        self._reader = reader
        self._kept: KeptMembers[V] | None = None
        self._initial = which if isinstance(which, Member) else None
        self._pair: tuple[str, ...] = ()
        self._requested: int | None = None  # the member to simulate
        self._member = Lines(id="member")
        self.title = run.name

    def content(self) -> ComposeResult:
        with Horizontal():
            with Vertical(id="members-left"):
                yield self.plot
                yield self._member
            yield self.pane

    def on_mount(self) -> None:
        self._follow()

    @abstractmethod
    def summary(self, kept: KeptMembers[V]) -> str:
        """Return the generation and the state of the search, in words."""

    # The members

    @work(group="follow")
    async def _follow(self) -> None:
        """Re-read the members when the run has new generations, while the screen is in front."""
        while True:
            start = time.monotonic()
            if self.is_current:
                try:
                    kept = await self.in_thread(self._reader.poll)
                except GaitsimError as error:
                    if self._kept is None:
                        self.plot.show_message(visible_lines(str(error)))
                else:
                    if kept is not None:
                        self._show_kept(kept)
            await asyncio.sleep(min(max(LOOK, SHARE * (time.monotonic() - start)), LONGEST))

    def _show_kept(self, kept: KeptMembers[V]) -> None:
        """Show members and keep the cursor."""
        if kept.view.names != (self._kept.view.names if self._kept else None):
            self._pair = next(iter(kept.view.pairs), kept.view.names)
        self._kept = kept
        self.sub_title = self.summary(kept)
        self.plot.show_message("no gait yet: every individual has failed so far")
        count = len(kept.view.members.scores)
        first, self._initial = self._initial, None
        wanted = first.number if first is not None and first.number <= count else None
        self._show(wanted)

    def _show(self, member: int | None) -> None:
        assert self._kept is not None
        view = self._kept.view
        self.plot.show(view, self._pair, axis_labels(view.names, self._reader.units), member)
        self.offers = bool(len(view.members.scores)), len(view.names)

    # The member under the cursor

    @on(MemberPlot.CursorMoved)
    def _moved(self) -> None:
        """Describe the member under the cursor and simulate it once the cursor rests."""
        kept, member = self._kept, self.plot.member
        if kept is None or member is None:
            return
        self._describe(kept, member)
        self._requested = member
        cached = self._reader.cached(kept, member)
        if cached is not None:
            self.pane.show(cached)
        elif not self.is_busy("member"):
            self._load()

    @work(group="member")
    async def _load(self) -> None:
        """Simulate the member under the cursor; repeat if the cursor has moved since."""
        while True:
            await asyncio.sleep(PAUSE)
            kept, requested = self._kept, self._requested
            assert kept is not None
            assert requested is not None
            units, moving = self._reader.units, self._reader.cached(kept, requested)
            if moving is None:
                try:
                    moving = await self.in_thread(self._reader.load, kept, requested)
                except GaitsimError as error:
                    if requested == self._requested:
                        self.pane.show_error(error)
            if requested == self._requested:
                if moving is not None:
                    self.pane.show(moving)
                if self._reader.units != units:  # they are known now
                    self._show(None)
                return

    def _describe(self, kept: KeptMembers[V], member: int) -> None:
        """Show number, score and values of a member below the plot."""
        width = max(self._member.size.width, 20)
        lines = self.describe_values(kept, member, width)
        shown = [Text(line, no_wrap=True, end="") for line in lines]
        self._member.show([self._head(kept.view, member), *shown])

    def _head(self, view: V, member: int) -> Text:
        """Return the number and the score of a member."""
        scores = view.members.scores
        head = Text(f"member {member:,}", "bold", no_wrap=True, end="", overflow="ellipsis")
        head.append(f" of {len(scores):,}", "not bold")
        head.append(" ★" if member == view.best else "")
        head.append(f"   score {number(float(scores[member - 1]), 4)}")
        return head

    @abstractmethod
    def describe_values(self, kept: KeptMembers[V], member: int, width: int) -> Sequence[str]:
        """Return the values of a member along all axes as lines of text."""

    # Actions

    def action_pair(self, steps: int) -> None:
        """Show the next pair of axes, with the cursor on the same gait."""
        assert self._kept is not None
        pairs = self._kept.view.pairs
        at = pairs.index(self._pair) if self._pair in pairs else 0
        self._turn(pairs[(at + steps) % len(pairs)])

    def action_axis(self, which: int) -> None:
        """Show the next horizontal (0) or vertical (1) axis."""
        assert self._kept is not None
        names = self._kept.view.names
        pair = [*self._pair]
        other = pair[1 - which]
        free = [name for name in names if name != other]
        pair[which] = free[(free.index(pair[which]) + 1) % len(free)]
        self._turn(tuple(pair))

    def _turn(self, pair: tuple[str, ...]) -> None:
        self._pair = pair
        self._show(self.plot.member)

    def action_best(self) -> None:
        if self._kept is not None:
            self.plot.go_to(self._kept.view.best)

    @work(group="ask", exclusive=True)
    async def action_go_to(self) -> None:
        """Ask for a member's number and go to it."""
        assert self._kept is not None
        last = len(self._kept.view.members.scores)
        check = partial(parse_number, kind="member", last=last)
        question = Ask("Go to member", check=check, about=f"1 to {last:,}")
        answer = await self.app.push_screen_wait(question)
        if answer is not None:
            self.plot.go_to(check(answer))

    def action_play(self) -> None:
        canvas = self.pane.canvas
        canvas.playing = not canvas.playing

    def action_view(self) -> None:
        self.pane.canvas.action_next_view()

    @property
    def choice(self) -> RunChoice:
        member = self.plot.member
        return RunChoice(self.run, None if member is None else Member(member))

    def command_line(self) -> str:
        axes = ("--axes", *self._pair) if len(self._pair) == 2 else ()
        return command("members", self.run, "--map", *axes)

    def obstacle(self, action: str) -> str:
        known, axes = self.offers
        if action in ("pair", "axis") and axes < 3:
            return "There are no other axes to show."
        if action in NEEDS_GAIT and not known:
            return "No gait is shown yet."
        return super().obstacle(action)
