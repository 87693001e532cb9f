"""Commands queued by the controlling process, executed between two generations."""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Protocol

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Command, State, read_command

PERIOD = 0.4  # seconds between two checks for a free place, and for the run's folder


class Place(Protocol):
    """A permit to evolve, if only some runs may evolve at a time."""

    def take(self) -> bool:
        """Return whether the run may evolve; if not, call it again later."""

    def leave(self) -> None:
        """Let another run evolve."""


class OwnPlace:
    """The place of a run that does not compete with others."""

    def take(self) -> bool:
        """Return True."""
        return True

    def leave(self) -> None:
        """Do nothing."""


class CommandQueue:
    """The queue of commands, and the state of the search: paused, queued or running.

    Args:
        paused: whether the search starts paused.
        place: place that is taken while the search runs.
        check: function called before each generation, and occasionally while the search is idle;
            raises a GaitsimError if the run cannot continue.
    """

    def __init__(
        self,
        *,
        paused: bool = False,
        place: Place | None = None,
        check: Callable[[], object] | None = None,
    ) -> None:
        self.paused = paused
        self._place = place or OwnPlace()
        self._check, self._checked = check or (lambda: None), check is not None
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._later: deque[Command] = deque()
        self._step = False

    def cause(self, error: GaitsimError) -> GaitsimError:
        """Return the underlying reason why the run cannot continue, or else the error itself.

        While a folder is being deleted, missing files cause other errors first.
        """
        try:
            self._check()
            time.sleep(PERIOD if self._checked else 0.0)
            self._check()
        except GaitsimError as cause:
            return cause
        return error

    def add(self, command: Command) -> None:
        """Add a command, from any thread or signal handler."""
        self._commands.put(command)

    def listen(self, lines: Iterable[bytes]) -> None:
        """Add the commands in lines, in a thread; add a `stop` after the last line."""

        def read() -> None:
            try:
                for line in lines:
                    command = read_command(line)
                    if command is not None:
                        self.add(command)
            except (OSError, ValueError):  # a broken stream ends the commands too
                pass
            self.add(Command("stop"))

        threading.Thread(target=read, daemon=True).start()

    def turn(self, on_state: Callable[[State], None]) -> bool:
        """Wait until a run that is not open yet may evolve; return False on a `stop`.

        A `set` is kept for `next`.

        Args:
            on_state: function called with `queued` or `paused` during the wait.

        Raises:
            GaitsimError: the run cannot continue.
        """
        resting, reported = False, ""
        while resting or not self._place.take():
            if resting:
                self._place.leave()
            reported = _report("paused" if resting else "queued", reported, on_state)
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
                    resting = self.paused = verb == "pause"
                    self._step = verb == "step"
        return True

    def next(self, on_state: Callable[[State], None]) -> Command | None:
        """Wait while paused or queued; return a `stop` or `set`, or None to evolve a generation.

        Args:
            on_state: function called with `paused` or `queued` before waiting, and with `running`
                before a generation.

        Raises:
            GaitsimError: the run cannot continue.
        """
        reported = ""
        while True:
            self._check()
            waits = True
            if self.paused and not self._step:
                self._place.leave()
                reported = _report("paused", reported, on_state)
            elif not self._place.take():
                reported = _report("queued", reported, on_state)
            elif self._step and not self._later:
                self._step, self.paused = False, True
                break
            else:
                waits = False
            command = self._later.popleft() if self._later else self._get(PERIOD if waits else 0.0)
            if command is not None and command.do in ("stop", "set"):
                return command
            if command is not None:
                self._step = command.do == "step"
                self.paused = self.paused if self._step else command.do == "pause"
            elif not waits:
                break
        on_state("running")
        return None

    def _get(self, seconds: float) -> Command | None:
        """Wait for the next command and return it; None if none arrives."""
        try:
            return self._commands.get(block=seconds > 0, timeout=seconds or None)
        except queue.Empty:
            return None


def _report(state: State, reported: str, on_state: Callable[[State], None]) -> str:
    """Report a state unless it was the last one reported; return it."""
    if state != reported:
        on_state(state)
    return state
