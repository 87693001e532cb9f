"""What whoever steers wishes, between two generations."""

import queue
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from gaitsim.experiment import Overrides
from gaitsim.live.protocol import Command, State, read_command


@dataclass(frozen=True)
class Stop:
    """To end, saved."""


@dataclass(frozen=True)
class Change:
    """To continue with options changed by key."""

    overrides: Overrides


class Wishes:
    """Commands as they come, and whether the search is paused.

    Args:
        paused: whether it begins so.
    """

    def __init__(self, *, paused: bool = False) -> None:
        self.paused = paused
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._stepping = False

    def add(self, command: Command) -> None:
        """Take a command, in any thread or signal handler."""
        self._commands.put(command)

    def listen(self, lines: Iterable[bytes]) -> None:
        """Take commands from lines in a thread, as long as there are any; then, a stop."""

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

    def granted(self, tell: Callable[[State], None]) -> Stop | Change | None:
        """Wait while paused; returns what else is wished, None to make a generation.

        Args:
            tell: called with `paused` before it waits, and `running` before a generation.
        """
        if self._stepping:
            self._stepping, self.paused = False, True
        while not self._stepping:
            if self.paused:
                tell("paused")
            try:
                command = self._commands.get(block=self.paused)
            except queue.Empty:
                break
            match command.do:
                case "stop":
                    return Stop()
                case "set":
                    return Change(command.overrides)
                case "step":
                    self._stepping = True
                case verb:
                    self.paused = verb == "pause"
        tell("running")
        return None
