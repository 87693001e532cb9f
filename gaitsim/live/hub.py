"""The clients of a process that evolves a run in the background."""

import asyncio
import socket
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from gaitsim.live.commands import CommandQueue
from gaitsim.live.protocol import read_command

LONGEST_COMMAND = 2**20  # bytes
PATIENCE = 2.0  # seconds that a client may leave what it was sent
TENDED_EVERY = 5.0  # seconds


class Hub:
    """Sends lines to all clients, and takes commands from them, in a thread of its own.

    A client that leaves does not matter. One that does not read is dropped, and may come back.

    Args:
        listener: a socket that listens.
        commands: receives the commands of all clients.
        tend: called every few seconds.
    """

    def __init__(
        self,
        listener: socket.socket,
        commands: CommandQueue,
        tend: Callable[[], object] = lambda: None,
    ) -> None:
        self._listener, self._commands, self._tend = listener, commands, tend
        self._greeting: Callable[[], bytes] = bytes
        self._clients: dict[asyncio.StreamWriter, float | None] = {}
        self._loop = asyncio.new_event_loop()
        self._work: set[asyncio.Task[None]] = set()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def serve(self, greeting: Callable[[], bytes]) -> None:
        """Begin; the first line for a client is the `greeting`, with everything known."""
        self._greeting = greeting
        self._thread.start()

    def write(self, line: bytes) -> None:
        """Send a line to all clients, from any thread; does not wait for them."""
        self._loop.call_soon_threadsafe(self._send, line)

    def close(self) -> None:
        """Send what is left, for a while, and end."""
        closing = asyncio.run_coroutine_threadsafe(self._close(), self._loop)
        with suppress(TimeoutError):
            closing.result(2 * PATIENCE)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._begin(self._listen())
        self._begin(self._look_after())
        self._loop.run_forever()

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._work.add(task)
        task.add_done_callback(self._work.discard)

    async def _listen(self) -> None:
        await asyncio.start_unix_server(self._serve, sock=self._listener, limit=LONGEST_COMMAND)

    async def _look_after(self) -> None:
        while True:
            self._tend()
            await asyncio.sleep(TENDED_EVERY)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(self._greeting())
        self._clients[writer] = None
        # A line that is too long is an end, too.
        with suppress(OSError, ValueError):
            while line := await reader.readline():
                command = read_command(line)
                if command is not None:
                    self._commands.add(command)
        self._clients.pop(writer, None)
        with suppress(OSError):
            writer.close()

    def _send(self, line: bytes) -> None:
        now = self._loop.time()
        for writer, behind in [*self._clients.items()]:
            if writer.transport.get_write_buffer_size() == 0:
                self._clients[writer] = None
            elif behind is None:
                self._clients[writer] = now
            elif now - behind > PATIENCE:
                del self._clients[writer]
                writer.transport.abort()
                continue
            writer.write(line)

    async def _close(self) -> None:
        for writer in self._clients:
            writer.close()
        waiting = [self._loop.create_task(self._finish(writer)) for writer in self._clients]
        if waiting:
            await asyncio.wait(waiting, timeout=PATIENCE)

    async def _finish(self, writer: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            await writer.wait_closed()
