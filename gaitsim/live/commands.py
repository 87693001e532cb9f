"""Commands queued by the controlling process, executed between two generations."""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Protocol

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Command, State, read_command

PERIOD = 0.4  # seconds between two checks for a free slot, and for the run's folder


class Slot(Protocol):
    """A permit to evolve, where the number of concurrent runs is limited."""

    def try_acquire(self) -> bool:
        """Return whether the run may evolve now; otherwise, the caller tries again later."""

    def release(self) -> None:
        """Release the slot, so that another run may evolve."""


class UnlimitedSlot:
    """A slot that is always free, for a run that does not compete with others."""

    def try_acquire(self) -> bool:
        """Return True."""
        return True

    def release(self) -> None:
        """Do nothing."""


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
        self._slot = slot or UnlimitedSlot()
        self._check, self._has_check = check or (lambda: None), check is not None
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._later: deque[Command] = deque()
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
            except (OSError, ValueError):  # treat a broken stream like the end of the lines
                pass
            self.add(Command("stop"))

        threading.Thread(target=read, daemon=True).start()

    def wait_for_slot(self, on_state: Callable[[State], None]) -> bool:
        """Wait for a slot before the run is opened; return False on a `stop`.

        A `set` is queued for `next`.

        Args:
            on_state: function called with `queued` or `paused` during the wait.
        """
        on_hold, reported = False, ""
        while on_hold or not self._slot.try_acquire():
            if on_hold:
                self._slot.release()
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

    def next(self, on_state: Callable[[State], None]) -> Command | None:
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
                self._slot.release()
                reported = _report("paused", reported, on_state)
            elif not self._slot.try_acquire():
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

    def _get(self, seconds: float) -> Command | None:
        """Wait for the next command and return it; None if none arrives."""
        try:
            return self._commands.get(block=seconds > 0, timeout=seconds or None)
        except queue.Empty:
            return None


def _report(state: State, reported: str, on_state: Callable[[State], None]) -> str:
    """Report a state unless it is `reported`, the last one; return it."""
    if state != reported:
        on_state(state)
    return state
