"""Evolve a run under commands, and report its progress."""

import queue
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.protocol import Best, RunCommand
from gaitsim.live.reporter import Reporter
from gaitsim.live.slots import Slot
from gaitsim.storage.background import RunState
from gaitsim.storage.writer import RunWriter

PERIOD = 0.4  # seconds between two checks for a free slot, and for the run's folder


class CommandQueue:
    """The queue of commands, and the state of the search: paused, queued or running.

    Args:
        paused: whether the search starts paused.
        slot: slot that the run holds while its search runs; None for no limit.
        check: function called before each generation, and occasionally while the search is idle;
            raises a GaitsimError if the run cannot continue.
    """

    def __init__(
        self,
        *,
        paused: bool = False,
        slot: Slot | None = None,
        check: Callable[[], object] | None = None,
    ) -> None:
        self.paused = paused
        self._slot = slot
        self._check, self._has_check = check or (lambda: None), check is not None
        self._commands: queue.SimpleQueue[RunCommand] = queue.SimpleQueue()
        self._later: deque[RunCommand] = deque()
        self._step = False

    def cause(self, error: GaitsimError) -> GaitsimError:
        """Return the reason why the run cannot continue, such as a deleted folder, or else `error`.

        While a folder is being deleted, its missing files cause other errors first.
        """
        try:
            self._check()
            time.sleep(PERIOD if self._has_check else 0.0)
            self._check()
        except GaitsimError as cause:
            return cause
        return error

    def add(self, command: RunCommand) -> None:
        """Add a command, from any thread or signal handler."""
        self._commands.put(command)

    def wait_for_slot(self, on_state: Callable[[RunState], None]) -> bool:
        """Wait for a slot before the run is opened; return False on a `stop`.

        A `set` is queued for `next`.

        It calls `on_state` with `queued` or `paused` during the wait.
        """
        on_hold, reported = False, ""
        while on_hold or not self._acquire_slot():
            if on_hold:
                self._release_slot()
            reported = _report("paused" if on_hold else "queued", reported, on_state)
            self._check()
            command = self._get(PERIOD)
            if command is None:
                continue
            match command.do:
                case "stop":
                    return False
                case "set":
                    self._later.append(command)
                case verb:
                    on_hold = self.paused = verb == "pause"
                    self._step = verb == "step"
        return True

    def next(self, on_state: Callable[[RunState], None]) -> RunCommand | None:
        """Wait while paused or queued; return a `stop` or `set`, or None to evolve a generation.

        Args:
            on_state: function called with `paused` or `queued` before waiting, and with `running`
                before a generation.
        """
        reported = ""
        while True:
            self._check()
            waiting = True
            if self.paused and not self._step:
                self._release_slot()
                reported = _report("paused", reported, on_state)
            elif not self._acquire_slot():
                reported = _report("queued", reported, on_state)
            elif self._step and not self._later:
                self._step, self.paused = False, True
                break
            else:
                waiting = False
            seconds = PERIOD if waiting else 0.0
            command = self._later.popleft() if self._later else self._get(seconds)
            if command is not None and command.do in ("stop", "set"):
                return command
            if command is not None:
                self._step = command.do == "step"
                self.paused = self.paused if self._step else command.do == "pause"
            elif not waiting:
                break
        on_state("running")
        return None

    def _acquire_slot(self) -> bool:
        return self._slot is None or self._slot.try_acquire()

    def _release_slot(self) -> None:
        if self._slot is not None:
            self._slot.release()

    def _get(self, seconds: float) -> RunCommand | None:
        """Wait for the next command and return it; None if none arrives."""
        try:
            return self._commands.get(block=seconds > 0, timeout=seconds or None)
        except queue.Empty:
            return None


def _report(state: RunState, reported: str, on_state: Callable[[RunState], None]) -> str:
    """Report a state unless it is `reported`, the last one; return it."""
    if state != reported:
        on_state(state)
    return state


def evolve_live(
    path: Path,
    commands: CommandQueue,
    reporter: Reporter,
    *,
    overrides: Overrides | None = None,
    generations: int | None = None,
    workers: int | None = None,
    any_version: bool = False,
) -> RunState:
    """Evolve the run in `path` until it is finished or stopped.

    A `set` closes and reopens the run. The other options are those of `plan_resume`.

    Returns:
        'finished', 'stopped' or 'failed'.
    """
    changes, opened = overrides or {}, False
    rejected: GaitsimError | None = None
    while True:
        try:
            if not opened and not commands.wait_for_slot(reporter.state):
                reporter.state("stopped")
                return "stopped"
            reporter.state("preparing", error=rejected)
            rejected = None
            with RunWriter.open(
                path,
                overrides=changes,
                generations=None if opened else generations,
                any_version=any_version,
                workers=workers,
                on_warning=reporter.warning,
            ) as writer:
                changes, opened = {}, True
                ended = _evolve(writer, commands, reporter)
        except GaitsimError as error:
            if opened and changes:  # rejected before anything was changed
                rejected, changes = error, {}
                continue
            reporter.state("failed", error=commands.cause(error))
            return "failed"
        # Reported after the run is closed, as the reader may open it immediately.
        if isinstance(ended, str):
            reporter.state("finished", ended)
            return "finished"
        if ended.do == "stop":
            reporter.state("stopped")
            return "stopped"
        changes = ended.overrides


def _evolve(writer: RunWriter, commands: CommandQueue, reporter: Reporter) -> str | RunCommand:
    """Evolve until a stop condition holds or a `stop` or `set` arrives, and return that."""
    reporter.run_opened(writer)
    if writer.done:
        reporter.evolution_starts(writer.last, _champion(writer))
        return writer.done
    writer.prepare().on_share = reporter.scored
    writer.reevaluate()
    reporter.evolution_starts(writer.last, _champion(writer))
    generations = writer.evolve()

    def report(state: RunState) -> None:
        if state != "running":
            writer.save()  # before waiting
        reporter.state(state)

    while True:
        command = commands.next(report)
        if command is not None:
            return command
        generation = next(generations)
        reporter.generation_finished(generation)
        if generation.stop:
            return generation.stop


def _champion(writer: RunWriter) -> Best | None:
    """Return the best individual with a comparable score, or None."""
    if writer.last is None or any(change.reevaluates for change in writer.changes):
        return None
    try:
        found = writer.run.individual()
    except RunError:
        return None
    if found.genome is None:
        return None
    return Best(found.generation, found.score, tuple(found.genome.tolist()))
