"""Map: the archive of a run as a heat map and the gait under the cursor."""

import asyncio
import time
from functools import partial
from pathlib import Path
from textwrap import wrap

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which
from gaitsim.render.terminal.text import number, visible, visible_lines
from gaitsim.storage.files.folder import command
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.atlas_source import Atlas, AtlasReader, Elite
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.screens.questions import Ask
from gaitsim.tui.screens.replay_loading import parse_number
from gaitsim.tui.screens.replay_pane import number_lines
from gaitsim.tui.widgets.archive_map import ArchiveMap
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.lines import Lines

FPS = 12
HIGH = 32  # minimum rows for all measures; with fewer rows, FEW are shown
FEW = 3
REASON = 3  # maximum lines of the reason for the gait's name
LOOK = 1.0  # seconds between two checks for new generations
SHARE = 10  # minimum pause between two reads, as a multiple of the time of a read
LONGEST = 10.0  # maximum pause, seconds
PAUSE = 0.1  # seconds for which the cursor rests before an elite is simulated
BEHAVIOUR = 3  # maximum lines of behaviour below the map


class ElitePane(Vertical):
    """A member of an archive in motion.

    Attributes:
        canvas: canvas of its body.
        elite: the member; None before the first one, or if it cannot be drawn.
    """

    DEFAULT_CSS = """
    ElitePane {
        width: 4fr; height: 1fr; border-left: solid $border-blurred;
        & > Lines, & > FootfallStrip { padding: 0 1; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self.canvas = BodyCanvas(message="no gait yet", fps=FPS)
        self.elite: Elite | None = None
        self._gait, self._measures, self._feet = Lines(), Lines(), FootfallStrip()

    def compose(self) -> ComposeResult:
        yield self._gait
        yield self.canvas
        yield self._measures
        yield self._feet

    def on_mount(self) -> None:
        self.canvas.playing = True

    def show(self, elite: Elite) -> None:
        """Show a member."""
        if elite is self.elite:
            return
        self.elite = elite
        skeleton = elite.shown.individual.skeleton
        self.canvas.set_skeleton(skeleton)
        self._feet.set_skeleton(skeleton)
        self._feet.frame = self.canvas.frame
        self._list(elite)

    def show_error(self, error: GaitsimError) -> None:
        """Show an error instead of the body."""
        self.elite = None
        self.canvas.set_skeleton(None, visible_lines(str(error)))
        self._feet.set_skeleton(None)
        for lines in (self._gait, self._measures):
            lines.show([])

    def _list(self, elite: Elite) -> None:
        """Show the gait's name and as many measures as fit."""
        width, high = max(self.content_size.width - 2, 16), self.size.height >= HIGH
        lines = []
        if elite.gait is not None:
            name = "no named gait" if elite.gait.name == "none" else elite.gait.name
            reason = Text(visible(elite.gait.reason), "dim", end="")
            lines = [Text(visible(name), "bold", end="")]
            lines += reason.wrap(self.app.console, width)[:REASON]
        self._gait.show(lines)
        measured = elite.shown.measurements.items()
        rows = [(name, one.value, one.unit) for name, one in measured]
        numbers = [*number_lines(rows, width)] if rows else []
        shown = numbers if high else numbers[:FEW]
        self._measures.show([Text(line, no_wrap=True, end="") for line in shown])

    @on(BodyCanvas.FrameShown)
    def _moved(self) -> None:
        self._feet.frame = self.canvas.frame

    def on_resize(self) -> None:
        if self.elite is not None:
            self._list(self.elite)


class Map(GaitScreen):
    """The archive of a run along two of its axes, with the elite under the cursor in motion.

    Args:
        run: folder of the run.
        which: member initially under the cursor; the best if it is not a member.

    Attributes:
        map: heat map with the cursor.
        pane: pane of the elite under the cursor.
    """

    HELP_TEXT = """
All gaits that a search has found, as a map of two axes: the colour of a cell is its best score;
dots are cells without a gait.

- **Arrow keys** or a click choose a gait. It moves on the right, with its name, footfalls and
  measures. Below the map are its number, score and position on all axes.
- **Axes**: with more than two axes, each cell shows the best score over the other axes. `]` and
  `[` step through pairs of axes, opposite legs first; `x` and `z` change one axis.
- **Best** selects the best gait, **Go to** a gait by its number.
- While the run evolves, the map fills, and the numbers of members change.
- **Replay**, **Why**, **Export** and the **Laboratory** apply to the gait under the cursor.
- The title shows the generation, the number and share of cells with a gait (the coverage), and the
  sum of all scores (the QD score).
"""
    BINDINGS = bindings("map")
    DEFAULT_CSS = """
    Map {
        & #map-left { width: 5fr; height: 1fr; padding: 0 1; }
        & #map-member { height: auto; }
        & ArchiveMap:focus { background-tint: $foreground 3%; }
    }
    """
    AUTO_FOCUS = "ArchiveMap"

    # Determines the available keys; a change updates the footer, which is slow.
    offers: reactive[tuple[bool, int]] = reactive((False, 0), init=False, bindings=True)

    def __init__(self, run: Path, which: Which = None) -> None:
        super().__init__()
        self.run = run
        self.map = ArchiveMap("reading the run …")
        self.pane = ElitePane()
        self._reader = AtlasReader(run)
        self._atlas: Atlas | None = None
        self._initial = which if isinstance(which, Member) else None
        self._pair: tuple[str, ...] = ()
        self._requested: int | None = None  # the member to simulate
        self._member = Lines(id="map-member")
        self.title, self.sub_title = run.name, "map"

    def content(self) -> ComposeResult:
        with Horizontal():
            with Vertical(id="map-left"):
                yield self.map
                yield self._member
            yield self.pane

    def on_mount(self) -> None:
        self._follow()

    # The archive

    @work(group="follow")
    async def _follow(self) -> None:
        """Re-read the archive when the run has new generations, while the screen is in front."""
        while True:
            start = time.monotonic()
            if self.is_current:
                try:
                    atlas = await self.in_thread(self._reader.poll)
                except GaitsimError as error:
                    if self._atlas is None:
                        self.map.show_message(visible_lines(str(error)))
                else:
                    if atlas is not None:
                        self._show_atlas(atlas)
            await asyncio.sleep(min(max(LOOK, SHARE * (time.monotonic() - start)), LONGEST))

    def _show_atlas(self, atlas: Atlas) -> None:
        """Show an archive and keep the cursor."""
        if atlas.view.names != (self._atlas.view.names if self._atlas else None):
            self._pair = next(iter(atlas.view.pairs), atlas.view.names)
        self._atlas = atlas
        self.sub_title = atlas.summary
        self.map.show_message("no gait yet: every individual has failed so far")
        count = len(atlas.view.members.scores)
        first, self._initial = self._initial, None
        wanted = first.number if first is not None and first.number <= count else None
        self._show(wanted)

    def _show(self, member: int | None) -> None:
        assert self._atlas is not None
        labels = self._reader.labels(self._atlas)
        self.map.show(self._atlas.view, self._pair, labels, member)
        self.offers = bool(len(self._atlas.view.members.scores)), len(self._atlas.view.names)

    # The elite under the cursor

    @on(ArchiveMap.CursorMoved)
    def _moved(self) -> None:
        """Describe the member under the cursor and simulate it once the cursor rests."""
        atlas, member = self._atlas, self.map.member
        if atlas is None or member is None:
            return
        self._describe(atlas, member)
        self._requested = member
        cached = self._reader.cached(atlas, member)
        if cached is not None:
            self.pane.show(cached)
        elif not self.is_busy("elite"):
            self._load()

    @work(group="elite")
    async def _load(self) -> None:
        """Simulate the member under the cursor; repeat if the cursor has moved since."""
        while True:
            await asyncio.sleep(PAUSE)
            atlas, requested = self._atlas, self._requested
            assert atlas is not None
            assert requested is not None
            elite = self._reader.cached(atlas, requested)
            if elite is None:
                try:
                    elite = await self.in_thread(self._reader.elite, atlas, requested)
                except GaitsimError as error:
                    if requested == self._requested:
                        self.pane.show_error(error)
            if requested == self._requested:
                if elite is not None:
                    self.pane.show(elite)
                if self.map.labels != self._reader.labels(atlas):  # the units are known now
                    self._show(None)
                return

    def _describe(self, atlas: Atlas, member: int) -> None:
        """Show number, score and behaviour of a member below the map."""
        members = atlas.view.members
        width = max(self._member.size.width, 20)
        head = Text(f"member {member:,}", "bold", no_wrap=True, end="", overflow="ellipsis")
        head.append(f" of {len(members.scores):,}", "not bold")
        head.append(" ★" if member == atlas.view.best else "")
        head.append(f"   score {number(float(members.scores[member - 1]), 4)}")
        shared, *items = atlas.behaviour(member)
        text = " ".join([shared, *items]) if shared else "  ".join(items)
        behaviour = [Text(line, no_wrap=True, end="") for line in wrap(text, width)[:BEHAVIOUR]]
        self._member.show([head, *behaviour])

    # Actions

    def action_pair(self, steps: int) -> None:
        """Show the next pair of axes, with the cursor on the same gait."""
        assert self._atlas is not None
        pairs = self._atlas.view.pairs
        at = pairs.index(self._pair) if self._pair in pairs else 0
        self._turn(pairs[(at + steps) % len(pairs)])

    def action_axis(self, which: int) -> None:
        """Show the next horizontal (0) or vertical (1) axis."""
        assert self._atlas is not None
        names = self._atlas.view.names
        pair = [*self._pair]
        other = pair[1 - which]
        free = [name for name in names if name != other]
        pair[which] = free[(free.index(pair[which]) + 1) % len(free)]
        self._turn(tuple(pair))

    def _turn(self, pair: tuple[str, ...]) -> None:
        self._pair = pair
        self._show(self.map.member)

    def action_best(self) -> None:
        if self._atlas is not None:
            self.map.go_to(self._atlas.view.best)

    @work(group="ask", exclusive=True)
    async def action_go_to(self) -> None:
        """Ask for a member's number and go to its cell."""
        assert self._atlas is not None
        last = len(self._atlas.view.members.scores)
        check = partial(parse_number, kind="member", last=last)
        question = Ask("Go to member", check=check, about=f"1 to {last:,}")
        answer = await self.app.push_screen_wait(question)
        if answer is not None:
            self.map.go_to(check(answer))

    def action_play(self) -> None:
        canvas = self.pane.canvas
        canvas.playing = not canvas.playing

    def action_view(self) -> None:
        self.pane.canvas.action_next_view()

    @property
    def choice(self) -> RunChoice:
        member = self.map.member
        return RunChoice(self.run, None if member is None else Member(member))

    def command_line(self) -> str:
        axes = ("--axes", *self._pair) if len(self._pair) == 2 else ()
        return command("members", self.run, "--map", *axes)

    def obstacle(self, action: str) -> str:
        known, axes = self.offers
        if action in ("pair", "axis") and axes < 3:
            return "The archive has no other axes to show."
        if (
            action in ("best", "go_to", "replay", "why", "export", "play", "view", "laboratory")
            and not known
        ):
            return "No gait is shown yet."
        return super().obstacle(action)
