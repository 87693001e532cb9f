"""The process that evolves a run, as who steers it has it."""

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
LAST_WORDS = 30  # lines of standard error that are kept


class Engine:
    """A run that evolves in a process of its own; an asynchronous iterator of snapshots.

    It outlives nothing: when this process ends, however it does, the other one stops
    after the generation that it is in. Ctrl-C in a terminal does not reach it.

    Args:
        run: its folder.
        generations: how far it is to go; None as far as planned.
        workers: how many work at a time; None for the usual number.
        overrides: options to change to begin with, by key.
        paused: whether it waits before its first generation.
        any_version: go on although a package has another version now.
        known: how the run stands, which holds until the process tells anew.
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
        self._last = _at_rest(known, "preparing") if known else Snapshot("preparing")
        self._pending: Snapshot | None = self._last
        self._news = asyncio.Event()
        self._news.set()
        self._words: deque[str] = deque(maxlen=LAST_WORDS)

    @property
    def last(self) -> Snapshot:
        """The newest snapshot."""
        return self._last

    async def start(self) -> None:
        """Start the process. A second call does nothing."""
        if self._process is not None or self._last.ended:
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
            asyncio.create_task(self._overhear(self._process)),
        ]

    async def __aiter__(self) -> AsyncIterator[Snapshot]:
        """Snapshots until one that ends; what came while no one took it is merged."""
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
        """Pause after the generation that is being made."""
        self._send(Command("pause"))

    def go(self) -> None:
        """Go on from a pause."""
        self._send(Command("go"))

    def step(self) -> None:
        """Make one generation, then pause."""
        self._send(Command("step"))

    def change(self, overrides: Overrides) -> None:
        """Continue with options changed by key, as a stage."""
        self._send(Command("set", overrides))

    def stop(self) -> None:
        """Stop after this generation, saved."""
        self._send(Command("stop"))

    def kill(self) -> None:
        """End the process at once; the run stands as of the last generation that was finished."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    async def ended(self) -> Snapshot:
        """Wait for the end of the process; the last snapshot."""
        if self._process is not None:
            await asyncio.gather(*self._tasks)
            await self._process.wait()
        return self._last

    def _send(self, wish: Command) -> None:
        process = self._process
        if process is None or process.stdin is None or process.stdin.is_closing():
            return
        with contextlib.suppress(ConnectionError, RuntimeError):  # it has just ended
            process.stdin.write(write_command(wish))

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                self._take(read_snapshot(line, self._last))
        except ValueError as error:  # not ours, or longer than any that is
            self.kill()
            self._words.append(str(error))
        code = await process.wait()
        if not self._last.ended:
            await asyncio.wait(self._tasks[1:], timeout=1)  # for its last words
            how = f"by signal {-code}" if code < 0 else f"with code {code}"
            self._take(self._failed(f"the evolution's process ended unexpectedly, {how}"))

    async def _overhear(self, process: asyncio.subprocess.Process) -> None:
        """Keep the last words of standard error, and so that no one waits to be heard."""
        assert process.stderr is not None
        rest = b""
        while data := await process.stderr.read(65536):
            *whole, rest = (rest + data).split(b"\n")
            self._words.extend(line.decode(errors="replace") for line in whole)
            rest = rest[-10_000:]
        if rest:
            self._words.append(rest.decode(errors="replace"))

    def _failed(self, what: str) -> Snapshot:
        words = next((line for line in reversed(self._words) if line.strip()), "")
        error = GaitsimError(
            f"{what}: {words.strip()}" if words else what,
            where=str(self.run),
            remedy=f"the run is whole; go on with: {command('resume', self.run)}",
        )
        return replace(_at_rest(self._last, "failed"), error=error)

    def _take(self, snapshot: Snapshot) -> None:
        self._last = snapshot
        self._pending = merged(self._pending, snapshot) if self._pending else snapshot
        self._news.set()


def _typed(value: Any) -> str:
    """Return a value as a person types it."""
    return value if isinstance(value, Typed) else text(value)


def _at_rest(known: Snapshot, state: State) -> Snapshot:
    """How far a run is known to be, in a state in which nothing is new."""
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
