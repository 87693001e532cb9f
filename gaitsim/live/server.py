"""The socket of a background process, through which any number of clients control its run."""

import asyncio
import json
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import psutil
from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError, RunError
from gaitsim.live.evolving import CommandQueue
from gaitsim.live.protocol import RunCommand, read_command
from gaitsim.live.reporter import Reporter
from gaitsim.live.slots import Slot, slot_count
from gaitsim.storage.background import (
    FAILURE,
    LOCK,
    LOG,
    SOCKET,
    STATE_PREDICATES,
    STATUS,
    VARIABLE,
    address,
    background_error,
    background_process,
    create_runtime_folder,
    identity,
    runtime_file,
)
from gaitsim.storage.files.folder import deleted_or_moved

BACKLOG = 32  # clients that may wait to be connected
LONGEST_LOG = 2**20  # bytes
LONGEST_COMMAND = 2**20  # bytes
PATIENCE = 2.0  # seconds for which a client may leave lines unread
MAINTENANCE_PERIOD = 5.0  # seconds


class Presence:
    """The files that make this process visible to others, until it publishes a final state.

    Attributes:
        listener: listening socket.
    """

    def __init__(self, run: Path) -> None:
        folder = create_runtime_folder()
        self._run = run
        self._path, self._identity = os.path.realpath(run), identity(run)
        self._files = {
            kind: runtime_file(run, kind, folder) for kind in (STATUS, FAILURE, LOCK, SOCKET, LOG)
        }
        self._process = {"pid": os.getpid(), "started": psutil.Process().create_time()}
        self._state = ""
        self._lock = FileLock(self._files[LOCK])
        try:
            # Wait a moment, because a check for a living process also holds the lock.
            self._lock.acquire(timeout=0.5, poll_interval=0.02)
        except Timeout:
            found = background_process(run)
            raise (
                background_error(run, found)
                if found
                else RunError(
                    f"the run {run} {STATE_PREDICATES['preparing']} in the background",
                    remedy="try again",
                )
            ) from None
        except OSError as error:
            raise _unusable(folder, error) from None
        with ExitStack() as cleanup:
            cleanup.callback(self._close, None)
            self.check()
            self.listener = cleanup.enter_context(socket.socket(socket.AF_UNIX))
            try:
                self._files[SOCKET].unlink(missing_ok=True)  # left by a killed process
                with address(self._files[SOCKET]) as name:
                    self.listener.bind(name)
                self.listener.listen(BACKLOG)
                self._write(STATUS, state="preparing", **self._process)
            except OSError as error:
                raise _unusable(folder, error) from None
            cleanup.pop_all()

    def check(self) -> None:
        """Check that the run's folder still exists."""
        if self._identity is None or identity(self._run) != self._identity:
            raise deleted_or_moved(self._run)

    def redirect(self) -> None:
        """Redirect all output of this process to the log, and close its input."""
        nothing = os.open(os.devnull, os.O_RDWR)
        try:
            log = os.open(
                self._files[LOG], os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o600
            )
        except OSError:
            log = os.dup(nothing)
        for descriptor, target in ((nothing, 0), (log, 1), (log, 2)):
            os.dup2(descriptor, target)
        os.close(nothing)
        os.close(log)

    def maintain(self) -> None:
        """Truncate a long log, and touch the files, because systems delete old temporary files."""
        with suppress(OSError):
            if os.fstat(2).st_size > LONGEST_LOG:
                os.ftruncate(2, 0)
        for path in self._files.values():
            with suppress(OSError):
                os.utime(path)
        with suppress(OSError):
            os.utime(self._files[LOCK].parent)

    def publish_state(self, state: str, error: GaitsimError | None = None) -> None:
        """Publish a state; remove the files if it is final."""
        if state == self._state:
            return
        self._state = state
        if state in ("finished", "stopped", "failed"):
            self._close(error)
        else:
            with suppress(OSError):
                self._write(STATUS, state=state, **self._process)

    def _close(self, error: GaitsimError | None) -> None:
        with suppress(OSError):
            self._files[SOCKET].unlink(missing_ok=True)
            # If the error cannot be stored, the status remains, which shows that the process died.
            if error is not None:
                self._write(FAILURE, error=error.to_dict())
            for kind in (STATUS, LOG):
                self._files[kind].unlink(missing_ok=True)
        with suppress(OSError):
            # Removed before the release, so that a waiting process locks a new file.
            self._files[LOCK].unlink(missing_ok=True)
            self._lock.release()

    def _write(self, kind: str, **values: object) -> None:
        path = self._files[kind]
        draft = path.with_name(f"{path.name}.{os.getpid()}")
        data = json.dumps({"run": self._path, "identity": self._identity, **values})
        try:
            draft.write_text(data, encoding="utf-8")
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)


def _unusable(folder: Path, error: OSError) -> GaitsimError:
    return GaitsimError(
        f"cannot evolve runs in the background: {error.strerror or error}",
        where=str(folder),
        remedy=f"set the environment variable {VARIABLE} to another folder",
    )


class Hub:
    """A server that sends lines to all clients and receives their commands, in its own thread.

    Clients may disconnect at any time. A client that does not read is disconnected, and may
    reconnect.

    Args:
        listener: listening socket.
        on_command: function called with each command of a client.
        maintain: function called every few seconds, for housekeeping.
    """

    def __init__(
        self,
        listener: socket.socket,
        on_command: Callable[[RunCommand], object],
        maintain: Callable[[], object] = lambda: None,
    ) -> None:
        self._listener, self._on_command, self._maintain = listener, on_command, maintain
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
                    self._on_command(command)
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


@contextmanager
def connect(run: Path, *, paused: bool) -> Iterator[tuple[CommandQueue, Reporter]]:
    """Accept commands from any client of a socket, and report to all clients."""
    slot = Slot(create_runtime_folder(), slot_count(), run)
    presence = Presence(run)
    commands = CommandQueue(paused=paused, slot=slot, check=presence.check)
    signal.signal(signal.SIGTERM, lambda *_: commands.add(RunCommand("stop")))
    hub = Hub(presence.listener, commands.add, presence.maintain)
    reporter = Reporter(hub.write, on_state=presence.publish_state)
    hub.serve(reporter.full_snapshot)
    with suppress(OSError):  # the parent process has ended
        print(json.dumps({"pid": os.getpid()}), flush=True)  # noqa: T201
    presence.redirect()
    try:
        yield commands, reporter
    finally:
        slot.release()
        hub.close()
