"""The connection to a process that evolves a run in the background."""

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
from gaitsim.live.protocol import Command, Snapshot, State, merged, read_snapshot, write_command
from gaitsim.live.watching import RunWatcher
from gaitsim.runs.background import SOCKET, background_process, last_failure, runtime_file

LONGEST_LINE = 2**26  # bytes: rows of 1000 generations with hundreds of terms
PERIOD = 0.1  # seconds between two attempts to connect


class RunProcess:
    """A run that evolves in the background; an asynchronous iterator of snapshots.

    The process outlives this one. If a process already evolves the run, this class connects to it
    and sends `generations`, `overrides` and `paused` as commands. Ctrl-C in a terminal does not
    reach the process.

    Args:
        run: folder of the run.
        overrides: options to change at the start, by key.
        paused: whether to pause before the first generation.
        known: snapshot of the run until the process reports.
        begin: whether to start a process if none evolves the run.

    Attributes:
        last: latest snapshot.
    """

    def __init__(
        self,
        run: Path,
        *,
        overrides: Overrides | None = None,
        paused: bool = False,
        known: Snapshot | None = None,
        begin: bool = True,
    ) -> None:
        self.run = run
        self._start_detached = partial(
            background.start_detached,
            run,
            overrides=overrides,
            paused=paused,
        )
        self._late = [Command("set", overrides)] if overrides else []
        self._late += [Command("pause")] if paused else []
        self._begin = begin
        self._writer: asyncio.StreamWriter | None = None
        self._reading: asyncio.Task[None] | None = None
        self._left = False
        self.last = _at_rest(known, "preparing") if known else Snapshot("preparing")
        self._pending: Snapshot | None = self.last
        self._news = asyncio.Event()
        self._news.set()

    @property
    def pid(self) -> int | None:
        """The process id; None without a process."""
        found = background_process(self.run)
        return found.pid if found else None

    async def start(self) -> None:
        """Connect to the process, and start it if there is none. A second call does nothing."""
        if self._reading is not None or self.last.ended or self._left:
            return
        begun = False
        try:
            if self._begin and background.evolving(self.run) is None:
                await asyncio.to_thread(self._start_detached)
                begun = True
        except GaitsimError as error:
            # Another process may have started it in the meantime.
            if background.evolving(self.run) is None:
                self._take(replace(_at_rest(self.last, "failed"), error=error))
                return
        if not begun:  # connected, so it reports immediately
            self._pending = None
            self._news.clear()
        reader = await self._connect()
        for late in () if begun else self._late:
            self._send(late)
        self._reading = asyncio.create_task(self._read(reader))

    async def __aiter__(self) -> AsyncIterator[Snapshot]:
        """Yield snapshots until the run ends; snapshots not consumed in time are merged."""
        await self.start()
        while True:
            await self._news.wait()
            if self._left:
                return
            self._news.clear()
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
        """Kill the process; the run loses at most the current generation."""
        background.kill(self.run)

    def leave(self) -> None:
        """Disconnect; the run continues to evolve, and the iterator ends."""
        self._left = True
        self._news.set()
        if self._writer is not None:
            # Closing before everything is read would reset the connection and lose commands.
            with contextlib.suppress(OSError, RuntimeError):
                self._writer.write_eof()

    async def ended(self) -> Snapshot:
        """Wait for the end of the process, or of the connection; return the last snapshot."""
        if self._reading is not None:
            await asyncio.wait([self._reading])
        return self.last

    def _send(self, command: Command) -> None:
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(write_command(command))

    async def _connect(self) -> asyncio.StreamReader | None:
        """Connect to the process; return None if it has ended."""
        while background.evolving(self.run) is not None:
            with contextlib.suppress(OSError), address(runtime_file(self.run, SOCKET)) as name:
                reader, self._writer = await asyncio.open_unix_connection(name, limit=LONGEST_LINE)
                return reader
            await asyncio.sleep(PERIOD)
        return None

    def _disconnect(self) -> None:
        if self._writer is not None:
            self._writer.close()

    async def _read(self, reader: asyncio.StreamReader | None) -> None:
        """Read snapshots until the run ends; reconnect if the connection breaks."""
        while reader is not None and not self.last.ended:
            # An invalid or overlong line ends the connection too.
            with contextlib.suppress(OSError, ValueError):
                async for line in reader:
                    if not self._left:
                        self._take(read_snapshot(line, self.last))
            self._disconnect()
            if self._left:
                return
            if not self.last.ended:
                await asyncio.sleep(PERIOD)
                reader = await self._connect()
        if not self.last.ended:
            self._take(await asyncio.to_thread(self._found))

    def _found(self) -> Snapshot:
        """Return the run's final snapshot after its process ended without a report."""
        error = last_failure(self.run)
        if error is not None:
            return replace(_at_rest(self.last, "failed"), error=error)
        found = RunWatcher(self.run).look()
        return found if found.ended else replace(found, state="stopped")

    def _take(self, snapshot: Snapshot) -> None:
        self.last = snapshot
        self._pending = merged(self._pending, snapshot) if self._pending else snapshot
        self._news.set()


def _at_rest(known: Snapshot, state: State) -> Snapshot:
    """Return a known snapshot in another state, without rows and events."""
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
