"""Commands queued by the controlling process, taken between two generations."""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Protocol

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Command, State, read_command

PERIOD = 0.4  # seconds between two looks for a free place, or whether the run is still there


class Place(Protocol):
    """What a run needs to evolve, where only some do at once."""

    def take(self) -> bool:
        """Return whether the run may evolve; ask again later otherwise."""

    def leave(self) -> None:
        """Let another run evolve."""


class OwnPlace:
    """The place of a run that no other waits for."""

    def take(self) -> bool:
        """Return True."""
        return True

    def leave(self) -> None:
        """Do nothing."""


class CommandQueue:
    """Commands as they arrive, and whether the search is paused or waits for its turn.

    Args:
        paused: whether it begins paused.
        place: taken while the search runs.
        check: called before each generation and now and then while the search rests; raises a
            GaitsimError where the run cannot continue.
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
        """Return why the run cannot continue at all, where that caused an error; else the error.

        A folder that is being deleted loses its files first.
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
        """Add the commands of lines in a thread; a `stop` after the last line."""

        def read() -> None:
            try:
                for line in lines:
                    command = read_command(line)
                    if command is not None:
                        self.add(command)
            except (OSError, ValueError):  # the stream broke, which is an end as well
                pass
            self.add(Command("stop"))

        threading.Thread(target=read, daemon=True).start()

    def turn(self, on_state: Callable[[State], None]) -> bool:
        """Wait for the turn of a run that is not open yet; return False on a `stop`.

        A `set` is kept for `next`.

        Args:
            on_state: called with `queued` or `paused` while it waits.

        Raises:
            GaitsimError: the run cannot continue.
        """
        resting, told = False, ""
        while resting or not self._place.take():
            if resting:
                self._place.leave()
            told = _tell("paused" if resting else "queued", told, on_state)
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
            on_state: called with `paused` or `queued` before waiting, and `running` before a
                generation.

        Raises:
            GaitsimError: the run cannot continue.
        """
        told = ""
        while True:
            self._check()
            waits = True
            if self.paused and not self._step:
                self._place.leave()
                told = _tell("paused", told, on_state)
            elif not self._place.take():
                told = _tell("queued", told, on_state)
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
        """Return the next command, waiting for it; None where none comes."""
        try:
            return self._commands.get(block=seconds > 0, timeout=seconds or None)
        except queue.Empty:
            return None


def _tell(state: State, told: str, on_state: Callable[[State], None]) -> str:
    """Report a state that is new; return it."""
    if state != told:
        on_state(state)
    return state
