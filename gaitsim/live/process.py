"""Start, find, watch, control and stop the background processes of runs."""

import asyncio
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Unpack

from gaitsim.errors import GaitsimError, RunError, error_from_dict
from gaitsim.experiment import Overrides, Typed
from gaitsim.live.protocol import RunCommand, Snapshot, merge, read_snapshot, write_command
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.background import (
    SOCKET,
    BackgroundProcess,
    RunState,
    address,
    background_process,
    last_failure,
    runtime_file,
)
from gaitsim.storage.lock import RunLock
from gaitsim.storage.resume import ResumeOptions, plan_resume
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.toml import text

START_TIMEOUT = 60.0  # seconds
ANSWER_TIMEOUT = 5.0  # seconds
SAME_START = 1.0  # seconds; a clock that was set moves the start of a process
CHECK_PERIOD = 0.05  # seconds between two checks for the end of a process

LONGEST_LINE = 2**26  # bytes: rows of 1000 generations with hundreds of terms
CONNECT_PERIOD = 0.1  # seconds between two attempts to connect


def background_state(run: Path) -> RunState | None:
    """Return the state of a run's background process; None if it has none."""
    found = background_process(run)
    return found.state if found else None


def detach(run: Path, *, workers: int | None = None, **options: Unpack[ResumeOptions]) -> None:
    """Check that a run can continue, then evolve it in the background."""
    RunLock(run).release()
    plan = plan_resume(RunSnapshot(run, keep_damaged=True), **options)
    for entry in plan.experiment.outside:
        raise GaitsimError(
            f"the {entry} cannot be sent to another process",
            where=entry.target,
            remedy="continue the run in this process: run.resume()",
        )
    start_detached(run, workers=workers, **options)


def start_detached(
    run: Path,
    *,
    workers: int | None = None,
    paused: bool = False,
    **options: Unpack[ResumeOptions],
) -> int:
    """Evolve a run in its own process, which outlives this one; return its process ID.

    The run starts immediately, or is queued if one background run per core is already evolving.
    Later failures are reported to its clients and by
    `gaitsim.storage.background.last_failure`. The options are those of `plan_resume`.
    """
    if sys.platform == "win32":
        raise GaitsimError("background runs are not supported on Windows", remedy="omit --detach")
    generations, overrides = options.get("generations"), options.get("overrides") or {}
    arguments = [
        *([f"--generations={generations}"] if generations is not None else []),
        *([f"--workers={workers}"] if workers is not None else []),
        *(
            f"--set={key}={value if isinstance(value, Typed) else text(value)}"
            for key, value in overrides.items()
        ),
        *(["--paused"] if paused else []),
        *(["--any-version"] if options.get("any_version") else []),
    ]
    errors = b""
    try:
        done = subprocess.run(
            [sys.executable, "-m", "gaitsim.live", *arguments, "--", str(run)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            start_new_session=True,  # keeps Ctrl-C and SIGHUP from the child
            check=False,
            timeout=START_TIMEOUT,
        )
        errors = done.stderr
        answer = json.loads(done.stdout)
    except (OSError, subprocess.TimeoutExpired, ValueError) as error:
        reason = next(iter(errors.decode(errors="replace").strip().splitlines()[-1:]), str(error))
        raise GaitsimError(
            f"cannot start the background process of the run: {reason}", where=str(run)
        ) from None
    if "error" in answer:
        raise error_from_dict(answer["error"])
    return int(answer["pid"])


def stop(run: Path, timeout: float | None = None) -> bool:
    """Save and stop a background run after its current generation.

    Returns:
        Whether the process has ended.
    """
    found = request_stop(run)
    if found is None:
        raise RunError(
            f"the run {run} is not evolving in the background",
            remedy="list the runs and their states with 'gaitsim runs'",
        )
    end = None if timeout is None else time.monotonic() + timeout
    while (left := background_process(run)) is not None and left.pid == found.pid:
        if end is not None and time.monotonic() >= end:
            return False
        time.sleep(CHECK_PERIOD)
    return True


def request_stop(run: Path) -> BackgroundProcess | None:
    """Ask a background run to stop after its current generation; return its process, if any.

    A signal is sent, because it arrives even while the process does not accept commands.
    """
    return _signal(run, signal.SIGTERM)


def send(run: Path, *commands: RunCommand) -> None:
    """Send commands to the background process of a run."""
    try:
        with (
            socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client,
            address(runtime_file(run, SOCKET)) as name,
        ):
            client.settimeout(ANSWER_TIMEOUT)
            client.connect(name)
            client.sendall(b"".join(map(write_command, commands)))
            # Closing before everything is read would reset the connection and lose commands.
            client.shutdown(socket.SHUT_WR)
            while client.recv(65536):
                pass
    except OSError as error:
        raise RunError(
            f"the background process of the run {run} does not accept commands: "
            f"{error.strerror or error}",
            remedy="list the runs and their states with 'gaitsim runs'",
        ) from None


def kill(run: Path) -> None:
    """Kill the background process of a run; its unsaved generations are lost."""
    if sys.platform != "win32":
        _signal(run, signal.SIGKILL)


def _signal(run: Path, number: signal.Signals) -> BackgroundProcess | None:
    """Send a signal to the process of a run, if any, and return it.

    None is sent to another process that has got the ID of one that has ended.
    """
    import psutil

    found = background_process(run)
    if found is not None:
        with suppress(psutil.NoSuchProcess):
            process = psutil.Process(found.pid)
            if abs(process.create_time() - found.started) < SAME_START:
                process.send_signal(number)
    return found


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
            start_detached,
            run,
            overrides=overrides,
            paused=paused,
        )
        self._requests = [RunCommand("set", overrides)] if overrides else []
        self._requests += [RunCommand("pause")] if paused else []
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
            if self._launch and background_state(self.run) is None:
                await asyncio.to_thread(self._start_detached)
                launched = True
        except GaitsimError as error:
            # Another process may have started it in the meantime.
            if background_state(self.run) is None:
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
        self._send(RunCommand("pause"))

    def go(self) -> None:
        """Continue after a pause."""
        self._send(RunCommand("go"))

    def step(self) -> None:
        """Evolve one generation, then pause."""
        self._send(RunCommand("step"))

    def change(self, overrides: Overrides) -> None:
        """Continue with options changed by key, as a stage."""
        self._send(RunCommand("set", overrides))

    def stop(self) -> None:
        """Save and stop after the current generation."""
        request_stop(self.run)

    def kill(self) -> None:
        """Kill the process; the run loses its unsaved generations."""
        kill(self.run)

    def disconnect(self) -> None:
        """Disconnect and end the iterator; the run continues to evolve."""
        self._disconnected = True
        self._updated.set()
        if self._writer is not None:
            # Closing before everything is read would reset the connection and lose commands.
            with suppress(OSError, RuntimeError):
                self._writer.write_eof()

    async def wait_ended(self) -> Snapshot:
        """Wait for the end of the process, or of the connection; return the last snapshot."""
        if self._reading is not None:
            await asyncio.wait([self._reading])
        return self.last

    def _send(self, command: RunCommand) -> None:
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(write_command(command))

    async def _connect(self) -> asyncio.StreamReader | None:
        """Connect to the process; return None if it has ended."""
        while background_state(self.run) is not None:
            with suppress(OSError), address(runtime_file(self.run, SOCKET)) as name:
                reader, self._writer = await asyncio.open_unix_connection(name, limit=LONGEST_LINE)
                return reader
            await asyncio.sleep(CONNECT_PERIOD)
        return None

    async def _read(self, reader: asyncio.StreamReader | None) -> None:
        """Read snapshots until the run ends; reconnect if the connection breaks."""
        while reader is not None and not self.last.ended:
            # An invalid or overlong line ends the connection, too.
            with suppress(OSError, ValueError):
                async for line in reader:
                    if not self._disconnected:
                        self._accept(read_snapshot(line, self.last))
            if self._writer is not None:
                self._writer.close()
            if self._disconnected:
                return
            if not self.last.ended:
                await asyncio.sleep(CONNECT_PERIOD)
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


def _in_state(known: Snapshot, state: RunState) -> Snapshot:
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
