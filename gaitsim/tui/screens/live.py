"""Live: a run that evolves in the background, evolves in another program, or is at rest."""

import asyncio
import time
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.reactive import reactive

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides
from gaitsim.live.background import evolving
from gaitsim.live.process import RunProcess
from gaitsim.live.protocol import Snapshot
from gaitsim.live.watching import RunWatcher
from gaitsim.runs.background import DOES
from gaitsim.runs.files.folder import command
from gaitsim.runs.files.lock import is_locked
from gaitsim.runs.fork import fork_run
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.live_board import Board
from gaitsim.tui.screens.live_dialogs import ask_changes, ask_generations
from gaitsim.tui.screens.live_source import about, explained, keeps_archive
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header

RESTING = ("stopped", "failed")
LOOK = 1.0  # seconds between two looks whether someone else evolves a run that rests here


class Live(GaitScreen):
    """A run: evolved in the background, in a process that any number of these screens steer;
    followed while another program writes it; or at rest.

    Args:
        run: its folder.
        go: whether to continue it at once.
        clock: seconds that pass, for the body that moves.

    Attributes:
        board: the panels.
        process: the connection to the process that evolves the run; None while none does.
    """

    CSS_PATH = "live.tcss"
    HELP_TEXT = """
A run as it evolves. The search runs in a process of its own, which saves every generation. It
evolves on when you leave this screen or the app; open the run again to steer it, here, in another
window or by `gaitsim attach`.

- **Space** pauses and continues. **n** makes one generation. **s** stops and saves.
- **Esc** leaves the run evolving.
- **c** changes options from the next generation on, such as a rate or the weight of a term.
  It is recorded in the run as a stage; curves of scores that cannot be compared begin anew.
- **f** copies the run as it is, to continue the copy under other options; the run itself continues.
- **g** sets how many generations it is to have.
- The table has the best score and its terms: over the generations, and of the best individuals.
- The body is the champion so far. Drag to turn it, roll to zoom; **r** replays any generation.
  The ground under it is left out while the run evolves, unless the body has the focus.
- **M** shows the archive of map-elites as a map, which fills as the run evolves.
- **l** shows what happened: ★ a better best, ⚑ a champion that was kept, ▶ a stage.
"""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "pause", "Pause", id="live.pause", tooltip="Pause after this generation"),
        Binding("space", "go", "Resume", id="live.go", tooltip="Continue the run"),
        Binding("n", "step", "Step", id="live.step", tooltip="One generation, then pause"),
        Binding("s", "stop", "Stop", id="live.stop", tooltip="Stop and save"),
        Binding("c", "change", "Change", id="live.change", tooltip="Change options from here on"),
        Binding("f", "fork", "Fork", id="live.fork", tooltip="Copy the run under other options"),
        Binding("r", "replay", "Replay", id="live.replay", tooltip="See any generation move"),
        Binding("M", "map", "Map", id="live.map", tooltip="The archive as a map, as it fills"),
        Binding("g", "goal", "Goal", id="live.goal", tooltip="How many generations it has"),
        Binding("w", "why", "Why", id="live.why", tooltip="Why the champion scored"),
        Binding("e", "export", "Export", id="live.export", tooltip="Gait files, plots, videos, …"),
        Binding(
            "L",
            "laboratory",
            "Laboratory",
            id="live.laboratory",
            tooltip="Remove legs of the champion, and adapt its gait",
        ),
        Binding("l", "log", "Events", id="live.log", tooltip="What happened, or the terms"),
    ]
    AUTO_FOCUS = ""

    # Everything that the keys depend on: the footer, which is slow, is updated only with it.
    offers: reactive[tuple[object, ...]] = reactive((), init=False, bindings=True)

    def __init__(
        self, run: Path, *, go: bool = False, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self.run = run
        self.board = Board(run, clock)
        self._go = go
        self.process: RunProcess | None = None
        self._stopping = self._has_archive = False
        self.title, self.sub_title = run.name, ""

    def compose(self) -> ComposeResult:
        yield Header()
        yield self.board
        yield Footer()

    @property
    def run_to_verify(self) -> Path | None:
        return self.run if self.snapshot.generation else None

    @property
    def snapshot(self) -> Snapshot:
        """The latest snapshot."""
        return self.board.live.snapshot

    @property
    def state(self) -> str:
        """The state of the run; `stopping` after that command."""
        state = self.snapshot.state
        return "stopping" if self._stopping and self.process is not None else state

    def on_mount(self) -> None:
        self.sub_title = about(self.run)
        self._look_for_archive()
        self._watch()
        self.set_interval(LOOK, self._look)

    # Where snapshots come from

    @work(group="source", exclusive=True)
    async def _watch(self) -> None:
        """Follow the run as its folder shows it, until a process in the background evolves it."""
        go, self._go = self._go, False
        async for found in RunWatcher(self.run):
            self.take(found if go else explained(found, self.snapshot, self.run))
            if evolving(self.run):
                self._start(begin=False)
                return
        if go and self.snapshot.state == "stopped":
            self._start()

    @work(group="archive")
    async def _look_for_archive(self) -> None:
        self._has_archive = await self.in_thread(keeps_archive, self.run)
        self._changed()

    def _look(self) -> None:
        """Follow a run that rested here, and that someone else evolves now."""
        at_rest = self.process is None and not self.is_busy("source")
        if at_rest and (evolving(self.run) or is_locked(self.run)):
            self._watch()

    def _start(
        self, overrides: Overrides | None = None, *, step: bool = False, begin: bool = True
    ) -> None:
        """Evolve the run in the background; without `begin`, steer the process that does."""
        engine = RunProcess(
            self.run, overrides=overrides, paused=step, known=self.snapshot, begin=begin
        )
        self.process, self._stopping = engine, False
        self.board.problem(None)
        self._steer(engine, step)

    @work(group="source", exclusive=True)
    async def _steer(self, engine: RunProcess, step: bool) -> None:
        await engine.start()
        if step:
            engine.step()
        async for snapshot in engine:
            self.take(snapshot)
        await engine.ended()
        self.process, self._stopping = None, False
        self._changed()

    def take(self, snapshot: Snapshot) -> None:
        """Take a snapshot; the state is shown at once, the rest drawn in its rhythm."""
        board = self.board
        board.live.take(snapshot)
        if snapshot.error is not None:
            board.problem(snapshot.error)
        if board.live.gap and not self.is_busy("reread"):
            self._reread()
        self._changed()

    def _changed(self) -> None:
        """Update board and footer."""
        self.board.state = state = self.state
        self.board.stale()
        self.offers = (
            state,
            self.process is not None,
            self.snapshot.champion is not None,
            self._has_archive,
        )

    @work(group="reread")
    async def _reread(self) -> None:
        watcher = RunWatcher(self.run)
        found = await asyncio.to_thread(watcher.look)
        if found.state != "failed":
            self.board.live.reread(found, watcher.history)

    # Steering

    def action_pause(self) -> None:
        if self.process is not None:
            self.process.pause()

    def action_go(self) -> None:
        if self.process is not None:
            self.process.go()
        else:
            self._start()

    def action_step(self) -> None:
        if self.process is not None:
            self.process.step()
        else:
            self._start(step=True)

    def action_stop(self) -> None:
        """Stop and save; the second time, stop at once."""
        if self.process is None:
            return
        if self._stopping:
            self.process.kill()
            return
        self.process.stop()
        self._stopping = True
        self._changed()

    @work(group="ask", exclusive=True)
    async def action_change(self) -> None:
        wanted = await ask_changes(self.app, self.run, self.snapshot)
        self._continue(wanted.overrides if wanted else None)

    @work(group="ask", exclusive=True)
    async def action_goal(self) -> None:
        self._continue(await ask_generations(self.app, self.snapshot))

    def _continue(self, overrides: Overrides | None) -> None:
        """Continue under a changed experiment, at once or from rest; None changes nothing."""
        if overrides is None:
            return
        self.board.problem(None)
        if self.process is not None:
            self.process.change(overrides)
        elif self.state in ("stopped", "finished", "failed"):
            self._start(overrides=overrides)

    @work(group="fork")
    async def action_fork(self) -> None:
        wanted = await ask_changes(self.app, self.run, self.snapshot, fork=True)
        if wanted is None:
            return
        try:
            copy = await asyncio.to_thread(
                fork_run, self.run, wanted.out, wanted.overrides, any_version=False
            )
        except GaitsimError as error:
            self.board.problem(error)
        else:
            self.notify(f"{copy}: a copy of {self.run}", title="Forked", markup=False)
            self.gaitsim.open_run(copy, go=True)

    def action_replay(self) -> None:
        self.gaitsim.open_replay(self.run)

    def action_map(self) -> None:
        self.gaitsim.open_map(self.run)

    def action_why(self) -> None:
        self.gaitsim.open_why(self.run)

    def action_export(self) -> None:
        self.gaitsim.open_export(self.run)

    def action_laboratory(self) -> None:
        self.gaitsim.open_laboratory(self.run)

    def action_log(self) -> None:
        self.toggle_class("-log")
        self.board.stale()

    # Leaving

    def action_back(self) -> None:
        """Leave the run evolving, and say how to come back and how to stop it."""
        if self.process is not None and self.app.screen_stack[-1] is self:
            what = DOES.get(self.state, "stops and is saved")
            stop = command("stop", self.run)
            said = f"Open it to watch and steer it; s there stops and saves it, as does {stop}"
            self.notify(said, title=f"{self.run.name} {what} in the background", markup=False)
        super().action_back()

    def on_unmount(self) -> None:
        """Leave the run to its process."""
        if self.process is not None:
            self.process.leave()

    # What can be done now

    def command_line(self) -> str:
        return command("resume", self.run)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if not self.is_mounted:
            return super().check_action(action, parameters)
        state, here = self.state, self.process is not None
        match action:
            case "pause":
                return here and state in ("running", "preparing", "queued")
            case "go":
                return state == "paused" if here else state in RESTING
            case "step":
                return state in ("running", "paused") if here else state in RESTING
            case "stop":
                return here
            case "change" | "goal":
                steered = state in ("queued", "running", "paused")
                return steered if here else state in (*RESTING, "finished")
            case "fork":
                return state != "failed" or self.snapshot.generation > 0
            case "map":
                return self._has_archive and self.snapshot.generation > 0
            case "replay" | "why" | "export" | "laboratory":
                return self.snapshot.champion is not None
        return super().check_action(action, parameters)
