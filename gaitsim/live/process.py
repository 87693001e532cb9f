"""A connection to the background process of a run."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides
from gaitsim.live import background
from gaitsim.live.presence import address
from gaitsim.live.protocol import Command, Snapshot, State, merge, read_snapshot, write_command
from gaitsim.live.watching import RunWatcher
from gaitsim.runs.background import SOCKET, background_process, last_failure, runtime_file

LONGEST_LINE = 2**26  # bytes: rows of 1000 generations with hundreds of terms
PERIOD = 0.1  # seconds between two attempts to connect


class RunProcess:
    """A run that evolves in the background, as an asynchronous iterator of snapshots.

    The process outlives this one, and Ctrl-C in the terminal does not reach it. If a process
    already evolves the run, `overrides` and `paused` are sent to it as commands.

    Args:
        run: folder of the run.
        overrides: options to change at the start, by key.
        paused: whether to pause before the first generation.
        initial: snapshot of the run to yield until the process sends one; None for an empty one.
        launch: whether to start a process if the run has none.

    Attributes:
        last: latest snapshot.
    """

    def __init__(
        self,
        run: Path,
        *,
        overrides: Overrides | None = None,
        paused: bool = False,
        initial: Snapshot | None = None,
        launch: bool = True,
    ) -> None:
        self.run = run
        self._start_detached = partial(
            background.start_detached,
            run,
            overrides=overrides,
            paused=paused,
        )
        self._requests = [Command("set", overrides)] if overrides else []
        self._requests += [Command("pause")] if paused else []
        self._launch = launch
        self._writer: asyncio.StreamWriter | None = None
        self._reading: asyncio.Task[None] | None = None
        self._disconnected = False
        self.last = _in_state(initial, "preparing") if initial else Snapshot("preparing")
        self._pending: Snapshot | None = self.last
        self._updated = asyncio.Event()
        self._updated.set()

    @property
    def pid(self) -> int | None:
        """The process ID; None without a process."""
        found = background_process(self.run)
        return found.pid if found else None

    async def start(self) -> None:
        """Connect to the process; start one if there is none. A second call does nothing."""
        if self._reading is not None or self.last.ended or self._disconnected:
            return
        launched = False
        try:
            if self._launch and background.background_state(self.run) is None:
                await asyncio.to_thread(self._start_detached)
                launched = True
        except GaitsimError as error:
            # Another process may have started it in the meantime.
            if background.background_state(self.run) is None:
                self._accept(replace(_in_state(self.last, "failed"), error=error))
                return
        if not launched:  # the process sends a snapshot as soon as it is connected
            self._pending = None
            self._updated.clear()
        reader = await self._connect()
        for request in () if launched else self._requests:
            self._send(request)
        self._reading = asyncio.create_task(self._read(reader))

    async def __aiter__(self) -> AsyncIterator[Snapshot]:
        """Yield snapshots until the run ends; unread snapshots are merged."""
        await self.start()
        while True:
            await self._updated.wait()
            if self._disconnected:
                return
            self._updated.clear()
            snapshot, self._pending = self._pending, None
            if snapshot is not None:
                yield snapshot
                if snapshot.ended:
                    return

    def pause(self) -> None:
        """Pause after the current generation."""
        self._send(Command("pause"))

    def go(self) -> None:
        """Continue after a pause."""
        self._send(Command("go"))

    def step(self) -> None:
        """Evolve one generation, then pause."""
        self._send(Command("step"))

    def change(self, overrides: Overrides) -> None:
        """Continue with options changed by key, as a stage."""
        self._send(Command("set", overrides))

    def stop(self) -> None:
        """Save and stop after the current generation."""
        background.request_stop(self.run)

    def kill(self) -> None:
        """Kill the process; the run loses its unsaved generations."""
        background.kill(self.run)

    def disconnect(self) -> None:
        """Disconnect and end the iterator; the run continues to evolve."""
        self._disconnected = True
        self._updated.set()
        if self._writer is not None:
            # Closing before everything is read would reset the connection and lose commands.
            with contextlib.suppress(OSError, RuntimeError):
                self._writer.write_eof()

    async def wait_ended(self) -> Snapshot:
        """Wait for the end of the process, or of the connection; return the last snapshot."""
        if self._reading is not None:
            await asyncio.wait([self._reading])
        return self.last

    def _send(self, command: Command) -> None:
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(write_command(command))

    async def _connect(self) -> asyncio.StreamReader | None:
        """Connect to the process; return None if it has ended."""
        while background.background_state(self.run) is not None:
            with contextlib.suppress(OSError), address(runtime_file(self.run, SOCKET)) as name:
                reader, self._writer = await asyncio.open_unix_connection(name, limit=LONGEST_LINE)
                return reader
            await asyncio.sleep(PERIOD)
        return None

    def _close_writer(self) -> None:
        if self._writer is not None:
            self._writer.close()

    async def _read(self, reader: asyncio.StreamReader | None) -> None:
        """Read snapshots until the run ends; reconnect if the connection breaks."""
        while reader is not None and not self.last.ended:
            # An invalid or overlong line ends the connection, too.
            with contextlib.suppress(OSError, ValueError):
                async for line in reader:
                    if not self._disconnected:
                        self._accept(read_snapshot(line, self.last))
            self._close_writer()
            if self._disconnected:
                return
            if not self.last.ended:
                await asyncio.sleep(PERIOD)
                reader = await self._connect()
        if not self.last.ended:
            self._accept(await asyncio.to_thread(self._final_snapshot))

    def _final_snapshot(self) -> Snapshot:
        """Return the run's final snapshot after its process ended without a report."""
        error = last_failure(self.run)
        if error is not None:
            return replace(_in_state(self.last, "failed"), error=error)
        found = RunWatcher(self.run).poll()
        return found if found.ended else replace(found, state="stopped")

    def _accept(self, snapshot: Snapshot) -> None:
        self.last = snapshot
        self._pending = merge(self._pending, snapshot) if self._pending else snapshot
        self._updated.set()


def _in_state(known: Snapshot, state: State) -> Snapshot:
    """Return a known snapshot in a different state, without rows and events."""
    return replace(
        known,
        state=state,
        reason="",
        evaluations_per_second=0.0,
        generations_per_second=0.0,
        rows={},
        events=(),
        error=None,
    )
