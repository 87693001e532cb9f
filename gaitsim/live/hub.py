"""The clients of a background process."""

import asyncio
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from gaitsim.live.commands import CommandQueue
from gaitsim.live.protocol import read_command

LONGEST_COMMAND = 2**20  # bytes
PATIENCE = 2.0  # seconds for which a client may leave lines unread
MAINTENANCE_PERIOD = 5.0  # seconds


class Hub:
    """A server that sends lines to all clients and receives their commands, in its own thread.

    Clients may disconnect at any time. A client that does not read is disconnected, and may
    reconnect.

    Args:
        listener: listening socket.
        commands: queue for the commands of all clients.
        maintain: function called every few seconds, for housekeeping.
    """

    def __init__(
        self,
        listener: socket.socket,
        commands: CommandQueue,
        maintain: Callable[[], object] = lambda: None,
    ) -> None:
        self._listener, self._commands, self._maintain = listener, commands, maintain
        self._greeting: Callable[[], bytes] = bytes
        self._clients: dict[asyncio.StreamWriter, float | None] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._closing = asyncio.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()), daemon=True)

    def serve(self, greeting: Callable[[], bytes]) -> None:
        """Start serving; `greeting` returns the first line for each client."""
        self._greeting = greeting
        self._thread.start()
        self._ready.wait()

    def write(self, line: bytes) -> None:
        """Send a line to all clients without waiting; callable from any thread."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._send, line)

    def close(self) -> None:
        """Send the remaining lines, within a time limit, and stop serving."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._closing.set)
        self._thread.join(2 * PATIENCE)

    async def _run(self) -> None:
        self._loop = asyncio.get_running_loop()
        # Python 3.13 also removes the socket, and fails if the socket's address is not its path.
        keep: dict[str, Any] = {"cleanup_socket": False} if sys.version_info >= (3, 13) else {}
        server = await asyncio.start_unix_server(
            self._serve, sock=self._listener, limit=LONGEST_COMMAND, **keep
        )
        self._ready.set()
        while not self._closing.is_set():
            self._maintain()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._closing.wait(), MAINTENANCE_PERIOD)
        server.close()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._finish(), PATIENCE)

    async def _finish(self) -> None:
        """Wait until the clients have received all lines and disconnected."""
        for writer in [*self._clients]:
            with suppress(OSError):
                writer.close()
                await writer.wait_closed()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(self._greeting())
        self._clients[writer] = None
        # A line that is too long raises a ValueError; it ends the connection, too.
        with suppress(OSError, ValueError):
            while line := await reader.readline():
                command = read_command(line)
                if command is not None:
                    self._commands.add(command)
        self._clients.pop(writer, None)
        with suppress(OSError):
            writer.close()

    def _send(self, line: bytes) -> None:
        now = time.monotonic()
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
