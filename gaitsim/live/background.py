"""Start, find and stop the background processes of runs."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError, RunError, error_from_dict
from gaitsim.experiment import Overrides, Typed
from gaitsim.live.presence import address
from gaitsim.live.protocol import Command, State, write_command
from gaitsim.runs.background import (
    SOCKET,
    BackgroundProcess,
    background_process,
    runtime_file,
)
from gaitsim.runs.files.lock import RunLock
from gaitsim.runs.resume import plan_resume
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.toml import text

START_TIMEOUT = 60.0  # seconds
ANSWER_TIMEOUT = 5.0  # seconds
PERIOD = 0.05  # seconds between two checks for the end of a process


def background_state(run: Path) -> State | None:
    """Return the state of a run's background process; None if it has none."""
    found = background_process(run)
    return found.state if found else None


def check_detached(
    run: Path,
    overrides: Overrides | None = None,
    generations: int | None = None,
    *,
    any_version: bool = False,
) -> None:
    """Check that a run can continue, before it is queued."""
    RunLock(run).release()
    found = RunSnapshot(run, keep_damaged=True)
    plan = plan_resume(found, overrides, generations=generations, any_version=any_version)
    for entry in plan.experiment.outside:
        raise GaitsimError(
            f"the {entry} cannot be sent to another process",
            where=entry.target,
            remedy="continue the run in this process: run.resume()",
        )


def start_detached(
    run: Path,
    *,
    generations: int | None = None,
    workers: int | None = None,
    overrides: Overrides | None = None,
    paused: bool = False,
    any_version: bool = False,
) -> int:
    """Evolve a run in its own process, which outlives this one; return its process ID.

    The run starts immediately, or is queued if one background run per core is already evolving.
    Later failures are reported to its clients and by
    `gaitsim.runs.background.last_failure`.

    Args:
        run: folder of the run.
        generations: last generation to evolve; None for the number originally planned.
        workers: number of parallel workers; None for the default.
        overrides: options to change at the start, by key.
        paused: whether to pause before the first generation.
        any_version: whether to resume with different versions of packages.
    """
    if sys.platform == "win32":
        raise GaitsimError("background runs are not supported on Windows", remedy="omit --detach")
    arguments = [
        *([f"--generations={generations}"] if generations is not None else []),
        *([f"--workers={workers}"] if workers is not None else []),
        *(f"--set={key}={_as_typed(value)}" for key, value in (overrides or {}).items()),
        *(["--paused"] if paused else []),
        *(["--any-version"] if any_version else []),
    ]
    errors = b""
    try:
        done = subprocess.run(
            [sys.executable, "-m", "gaitsim.live", "--listen", *arguments, "--", str(run)],
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

    Args:
        run: folder of the run.
        timeout: maximum seconds to wait for the end of its process; None for no limit.

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
        time.sleep(PERIOD)
    return True


def request_stop(run: Path) -> BackgroundProcess | None:
    """Ask a background run to stop after its current generation; return its process, if any.

    A signal is sent, because it arrives even while the process does not accept commands.
    """
    found = background_process(run)
    if found is not None:
        _signal(found.pid, signal.SIGTERM)
    return found


def send(run: Path, *commands: Command) -> None:
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
    found = background_process(run)
    if found is not None and sys.platform != "win32":
        _signal(found.pid, signal.SIGKILL)


def _signal(pid: int, number: signal.Signals) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, number)


def _as_typed(value: Any) -> str:
    """Return a value in the syntax of `--set`."""
    return value if isinstance(value, Typed) else text(value)
