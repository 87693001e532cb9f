"""Live: a run that is evolving, here or in another program, or is stopped."""

import asyncio
import time
from collections.abc import Callable
from pathlib import Path

from textual import work
from textual.app import App, ComposeResult
from textual.reactive import reactive

from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.process import RunProcess, background_state
from gaitsim.live.protocol import Snapshot
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.background import STATE_PREDICATES
from gaitsim.storage.creation import fork_run
from gaitsim.storage.files.folder import command
from gaitsim.storage.lock import is_locked
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.screens.change import ChangeForm
from gaitsim.tui.screens.live_board import Board
from gaitsim.tui.screens.live_source import describe_run, kept_by, with_failure
from gaitsim.tui.screens.questions import Ask

RESTING = ("stopped", "failed")
LOOK = 1.0  # seconds between two checks whether another process evolves a stopped run
MOST_GENERATIONS = 100_000_000


class Live(GaitScreen):
    """A live or stopped run.

    A background process evolves the run, and any number of these screens can steer it. If another
    program evolves the run, the screen only follows it.

    Args:
        run: folder of the run.
        resume: whether to continue the run immediately.
        clock: function that returns the time in seconds, for the moving body.

    Attributes:
        board: panels of the screen.
        process: connection to the process that evolves the run; None without one.
    """

    CSS_PATH = "live.tcss"
    HELP_TEXT = """
A run as it evolves. The search runs in its own process, which saves the run and continues when you
leave this screen or the app. To steer it, open the run again, here, in another window or
with `gaitsim attach`.

- **Space** pauses and continues. **n** evolves one generation. **s** stops and saves.
- **Esc** leaves the screen; the run continues.
- **c** changes options, such as a rate or the weight of a term, starting with the next generation.
  The run records the change as a stage; if it makes scores incomparable, their curves restart.
- **f** copies the run, to continue the copy with other options; the original continues.
- **g** sets the number of generations.
- The table shows the score, its terms and the diversity: the best of each generation as a curve,
  and the mean and the best individuals (#1, #2, …) of the last generation.
- The body is the champion so far. Drag to turn it, scroll to zoom; **r** replays any generation.
  The ground is not drawn while the run evolves, unless the body has the focus.
- **M** shows the archive of map-elites as a map, which fills as the run evolves.
- **l** shows the events: ★ a new best score, ⚑ a saved champion, ▶ a stage.
"""
    BINDINGS = bindings("live")
    AUTO_FOCUS = ""

    # Determines the available keys; a change updates the footer, which is slow.
    offers: reactive[tuple[object, ...]] = reactive((), init=False, bindings=True)

    def __init__(
        self, run: Path, *, resume: bool = False, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self.run = run
        self.board = Board(run, clock)
        self._resume = resume
        self.process: RunProcess | None = None
        self._stopping = self._has_members = self._held = False
        self.title, self.sub_title = run.name, ""

    def content(self) -> ComposeResult:
        yield self.board

    @property
    def choice(self) -> RunChoice:
        return RunChoice(self.run)

    @property
    def to_verify(self) -> Path | None:
        return self.run if self.snapshot.generation else None

    @property
    def snapshot(self) -> Snapshot:
        """The latest snapshot."""
        return self.board.live.snapshot

    @property
    def state(self) -> str:
        """The state of the run; `stopping` after a stop was requested."""
        state = self.snapshot.state
        return "stopping" if self._stopping and self.process is not None else state

    def on_mount(self) -> None:
        self.sub_title = describe_run(self.run)
        self._look_for_members()
        self._watch()
        self.set_interval(LOOK, self._look)

    # Snapshots

    @work(group="source", exclusive=True)
    async def _watch(self) -> None:
        """Follow the run's folder until a background process evolves the run."""
        resume, self._resume = self._resume, False
        async for found in RunWatcher(self.run):
            self.take(found if resume else with_failure(found, self.snapshot, self.run))
            if background_state(self.run):
                self._start(launch=False)
                return
        if resume and self.snapshot.state == "stopped":
            self._start()

    @work(group="members")
    async def _look_for_members(self) -> None:
        self._has_members = bool(await self.in_thread(kept_by, self.run))
        self._changed()

    def _look(self) -> None:
        """Follow a stopped run once another process evolves it."""
        at_rest = self.process is None and not self.is_busy("source")
        if at_rest and (background_state(self.run) or is_locked(self.run)):
            self._watch()

    def _start(
        self, overrides: Overrides | None = None, *, step: bool = False, launch: bool = True
    ) -> None:
        """Evolve the run in the background; without `launch`, only connect to its process."""
        engine = RunProcess(
            self.run, overrides=overrides, paused=step, initial=self.snapshot, launch=launch
        )
        self.process, self._stopping = engine, False
        self.board.show_problem(None)
        if launch:
            self.take(engine.last)  # a process takes seconds to start
        self._steer(engine, step)

    @work(group="source", exclusive=True)
    async def _steer(self, engine: RunProcess, step: bool) -> None:
        await engine.start()
        if step:
            engine.step()
        async for snapshot in engine:
            self.take(snapshot)
        await engine.wait_ended()
        self.process, self._stopping = None, False
        self._changed()

    def take(self, snapshot: Snapshot) -> None:
        """Take a snapshot; show the state immediately, the rest at the next update."""
        board = self.board
        board.live.take(snapshot)
        if snapshot.state != "preparing":  # a paused run that prepares a change remains paused
            self._held = snapshot.state == "paused"
        if snapshot.error is not None:
            board.show_problem(snapshot.error)
        if board.live.gap and not self.is_busy("reread"):
            self._reread()
        self._changed()

    def _changed(self) -> None:
        """Update the board and the footer."""
        self.board.state = state = self.state
        self.board.schedule_redraw()
        self.offers = (
            state,
            self._held,
            self.process is not None,
            self.snapshot.champion is not None,
            self._has_members,
        )

    @work(group="reread")
    async def _reread(self) -> None:
        watcher = RunWatcher(self.run)
        found = await asyncio.to_thread(watcher.poll)
        if found.state != "failed":
            self.board.live.reread(found, watcher.history)

    # Steering

    def action_pause(self) -> None:
        if self.process is not None:
            self.process.pause()
            self._hold(self.state == "preparing")

    def action_go(self) -> None:
        if self.process is not None:
            self.process.go()
            self._hold(False)
        else:
            self._start()

    def _hold(self, held: bool) -> None:
        self._held = held
        self._changed()

    def action_step(self) -> None:
        if self.process is not None:
            self.process.step()
        else:
            self._start(step=True)

    def action_stop(self) -> None:
        """Stop and save after this generation; the second time, stop immediately."""
        if self.process is None:
            return
        if self._stopping:
            self.process.kill()
            return
        self.process.stop()
        self._stopping = True
        self._changed()

    def action_change(self) -> None:
        self._ask_changes(lambda overrides, _: self._continue(overrides))

    def _ask_changes(
        self, done: Callable[[Overrides, Path | None], object], *, fork: bool = False
    ) -> None:
        """Ask for options to change, starting with the next generation."""
        # A stage has at least one generation, so a finished run needs more generations.
        finished = self.snapshot.state == "finished"
        more = str(_suggested_generations(self.snapshot))
        changes = {"evolution.generations": more} if finished else {}
        self.app.push_screen(ChangeForm(self.run, done, fork=fork, changes=changes))

    @work(group="ask", exclusive=True)
    async def action_goal(self) -> None:
        self._continue(await ask_generations(self.app, self.snapshot))

    def _continue(self, overrides: Overrides | None) -> None:
        """Change options of an evolving run, or resume a stopped one with them.

        None does nothing.
        """
        if overrides is None:
            return
        self.board.show_problem(None)
        if self.process is not None:
            self.process.change(overrides)
        elif self.state in ("stopped", "finished", "failed"):
            self._start(overrides=overrides)

    def action_fork(self) -> None:
        self._ask_changes(self._copy, fork=True)

    @work(group="ask")
    async def _copy(self, overrides: Overrides, out: Path | None) -> None:
        """Copy the run with other options, and open the copy."""
        try:
            copy = await asyncio.to_thread(fork_run, self.run, out, overrides, any_version=False)
        except GaitsimError as error:
            self.board.show_problem(error)
        else:
            self.notify(f"{copy}: a copy of {self.run}", title="Forked", markup=False)
            self.show_screen("live.Live", copy, resume=True)

    def action_log(self) -> None:
        self.toggle_class("-log")
        self.board.schedule_redraw()

    # Leaving

    def action_back(self) -> None:
        """Leave the run evolving and show how to return to it and how to stop it."""
        if self.process is not None and self.app.screen_stack[-1] is self:
            what = STATE_PREDICATES.get(self.state, "stops and is saved")
            stop = command("stop", self.run)
            text = f"Open the run to watch and steer it. To stop it, press s there or run: {stop}"
            self.notify(text, title=f"{self.run.name} {what} in the background", markup=False)
        super().action_back()

    def on_unmount(self) -> None:
        """Disconnect from the process, which continues."""
        if self.process is not None:
            self.process.disconnect()

    # Available actions

    def command_line(self) -> str:
        return command("resume", self.run)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if not self.is_mounted:
            return super().check_action(action, parameters)
        state, here = self.state, self.process is not None
        match action:
            case "pause":
                return here and (
                    state in ("running", "queued") or (state == "preparing" and not self._held)
                )
            case "go":
                held = state == "paused" or (state == "preparing" and self._held)
                return held if here else state in RESTING
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
                return self._has_members and self.snapshot.generation > 0
            case "replay" | "why" | "export" | "on_individual" | "steer":
                return self.snapshot.champion is not None
        return super().check_action(action, parameters)


async def ask_generations(app: App[object], snapshot: Snapshot) -> Overrides | None:
    """Ask for the number of generations of a run; return None for no change."""
    done = snapshot.generation

    def check(text: str) -> None:
        number = int(text) if text.isascii() and text.isdecimal() and len(text) < 10 else 0
        if not done < number <= MOST_GENERATIONS:
            raise RunError(
                f"invalid number of generations: {text!r}",
                allowed=f"{done + 1:,} to {MOST_GENERATIONS:,}",
            )

    about = f"The run is at generation {done:,}."
    question = Ask("Evolve up to generation", str(_suggested_generations(snapshot)), check, about)
    answer = await app.push_screen_wait(question)
    return {"evolution.generations": int(answer)} if answer else None


def _suggested_generations(snapshot: Snapshot) -> int:
    """Return 1.5 times the generations of a run."""
    planned = max(snapshot.generations, snapshot.generation)
    return planned + max(1, planned // 2)
