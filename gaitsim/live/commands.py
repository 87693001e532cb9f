"""Commands queued by the controlling process, taken between two generations."""

import queue
import threading
from collections.abc import Callable, Iterable

from gaitsim.live.protocol import Command, State, read_command


class CommandQueue:
    """Commands as they arrive, and whether the search is paused.

    Args:
        paused: whether it begins paused.
    """

    def __init__(self, *, paused: bool = False) -> None:
        self.paused = paused
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._stepping = False

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

    def next(self, on_state: Callable[[State], None]) -> Command | None:
        """Wait while paused; return a `stop` or `set`, or None to evolve a generation.

        Args:
            on_state: called with `paused` before waiting, and `running` before a generation.
        """
        if self._stepping:
            self._stepping, self.paused = False, True
        while not self._stepping:
            if self.paused:
                on_state("paused")
            try:
                command = self._commands.get(block=self.paused)
            except queue.Empty:
                break
            match command.do:
                case "stop" | "set":
                    return command
                case "step":
                    self._stepping = True
                case verb:
                    self.paused = verb == "pause"
        on_state("running")
        return None
