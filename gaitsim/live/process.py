"""A process that evolves a run, seen from the process that controls it."""

import asyncio
import contextlib
import sys
from collections import deque
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides, Typed
from gaitsim.live.protocol import Command, Snapshot, State, merged, read_snapshot, write_command
from gaitsim.runs.files.folder import command
from gaitsim.toml import text

LONGEST_LINE = 2**26  # bytes: a thousand generations' rows with hundreds of terms
LINES_KEPT = 30  # lines of standard error that are kept


class RunProcess:
    """A run that evolves in a process of its own; an asynchronous iterator of snapshots.

    When this process ends, however it does, the other one stops after its current generation.
    Ctrl-C in a terminal does not reach it.

    Args:
        run: its folder.
        generations: the last generation to evolve; None as planned.
        workers: number of parallel workers; None for the usual number.
        overrides: options to change to begin with, by key.
        paused: whether it waits before its first generation.
        any_version: resume although a package has another version now.
        known: the run as it is, until the process reports.

    Attributes:
        last: the newest snapshot.
    """

    def __init__(
        self,
        run: Path,
        *,
        generations: int | None = None,
        workers: int | None = None,
        overrides: Overrides | None = None,
        paused: bool = False,
        any_version: bool = False,
        known: Snapshot | None = None,
    ) -> None:
        self.run = run
        self._arguments = [
            *([f"--generations={generations}"] if generations is not None else []),
            *([f"--workers={workers}"] if workers is not None else []),
            *(f"--set={key}={_typed(value)}" for key, value in (overrides or {}).items()),
            *(["--paused"] if paused else []),
            *(["--any-version"] if any_version else []),
        ]
        self._process: asyncio.subprocess.Process | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self.last = _at_rest(known, "preparing") if known else Snapshot("preparing")
        self._pending: Snapshot | None = self.last
        self._news = asyncio.Event()
        self._news.set()
        self._last_lines: deque[str] = deque(maxlen=LINES_KEPT)

    @property
    def pid(self) -> int | None:
        """The process's number; None before it starts."""
        return self._process.pid if self._process else None

    async def start(self) -> None:
        """Start the process. A second call does nothing."""
        if self._process is not None or self.last.ended:
            return
        try:
            self._process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "gaitsim.live",
                *self._arguments,
                "--",
                str(self.run),
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
                limit=LONGEST_LINE,
                start_new_session=True,  # so that Ctrl-C and a lost terminal are ours alone
            )
        except OSError as error:
            self._take(self._failed(f"the evolution cannot be started: {error.strerror}"))
            return
        self._tasks = [
            asyncio.create_task(self._read(self._process)),
            asyncio.create_task(self._drain_stderr(self._process)),
        ]

    async def __aiter__(self) -> AsyncIterator[Snapshot]:
        """Yield snapshots until one that ends; those that nobody took in time are merged."""
        await self.start()
        while True:
            await self._news.wait()
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
        """Stop after the current generation, saved."""
        self._send(Command("stop"))

    def kill(self) -> None:
        """Kill the process; the run loses at most the current generation."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    async def ended(self) -> Snapshot:
        """Wait for the end of the process; return the last snapshot."""
        if self._process is not None:
            await asyncio.gather(*self._tasks)
            await self._process.wait()
        return self.last

    def _send(self, command: Command) -> None:
        process = self._process
        if process is None or process.stdin is None or process.stdin.is_closing():
            return
        with contextlib.suppress(ConnectionError, RuntimeError):  # it has just ended
            process.stdin.write(write_command(command))

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                self._take(read_snapshot(line, self.last))
        except ValueError as error:  # not a snapshot, or longer than any
            self.kill()
            self._last_lines.append(str(error))
        code = await process.wait()
        if not self.last.ended:
            await asyncio.wait(self._tasks[1:], timeout=1)  # for its last lines
            how = f"by signal {-code}" if code < 0 else f"with code {code}"
            self._take(self._failed(f"the evolution's process ended unexpectedly, {how}"))

    async def _drain_stderr(self, process: asyncio.subprocess.Process) -> None:
        """Drain stderr so the child never blocks on it; keep its last lines."""
        assert process.stderr is not None
        rest = b""
        while data := await process.stderr.read(65536):
            *whole, rest = (rest + data).split(b"\n")
            self._last_lines.extend(line.decode(errors="replace") for line in whole)
            rest = rest[-10_000:]
        if rest:
            self._last_lines.append(rest.decode(errors="replace"))

    def _failed(self, what: str) -> Snapshot:
        said = next((line for line in reversed(self._last_lines) if line.strip()), "")
        error = GaitsimError(
            f"{what}: {said.strip()}" if said else what,
            where=str(self.run),
            remedy=f"the run is whole; continue with: {command('resume', self.run)}",
        )
        return replace(_at_rest(self.last, "failed"), error=error)

    def _take(self, snapshot: Snapshot) -> None:
        self.last = snapshot
        self._pending = merged(self._pending, snapshot) if self._pending else snapshot
        self._news.set()


def _typed(value: Any) -> str:
    """Return a value as a person types it."""
    return value if isinstance(value, Typed) else text(value)


def _at_rest(known: Snapshot, state: State) -> Snapshot:
    """Return a known snapshot in another state, without news."""
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
