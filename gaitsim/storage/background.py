"""Processes that evolve runs in the background, listed in a private folder of the user.

Each process has files there, named by a hash of the real path of its run:

    KEY.lock     locked while the process lives, however it ends
    KEY.json     process ID and state; left behind by a killed process
    KEY.failure  why the last process failed, until the run is evolved again
    KEY.sock     socket for commands and reports
    KEY.log      output of plugins and libraries

The folder is `/tmp/gaitsim-UID`, or `GAITSIM_RUNTIME_DIR`. It is not `XDG_RUNTIME_DIR`, which is
removed at logout, while background runs continue.
"""

import hashlib
import json
import os
import stat
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from gaitsim.errors import GaitsimError, RunError, error_from_dict
from gaitsim.opening import open_descriptor, read_regular
from gaitsim.storage.files.folder import command

if sys.platform != "win32":
    import fcntl

VARIABLE = "GAITSIM_RUNTIME_DIR"
STATUS, FAILURE, LOCK, SOCKET, LOG = ".json", ".failure", ".lock", ".sock", ".log"
LARGEST = 2**20  # bytes of a status or an error
LONGEST_ADDRESS = 100  # bytes of a socket's address; the limit is 104 on macOS, 108 on Linux
END_OF_LOG = 10_000  # bytes at the end of the log that are searched for the last line

RunState = Literal[
    "preparing",
    "queued",
    "running",
    "paused",
    "finished",
    "stopped",
    "failed",
    "elsewhere",
    "older format",
    "newer format",
    "damaged",
]
"""State of a run: preparing (its process is starting), queued or paused (its process is waiting),
running, finished (a stop condition holds), stopped (it can be resumed), failed (its process failed;
it can be resumed), elsewhere (a program that cannot be controlled writes it), in an older or newer
format (written by another version of gaitsim), or damaged."""
# Predicate for messages about a background run, by state.
STATE_PREDICATES: Mapping[str, str] = {
    "preparing": "is being prepared",
    "queued": "is queued",
    "running": "is evolving",
    "paused": "is paused",
}


@dataclass(frozen=True)
class BackgroundProcess:
    """A process that evolves a run in the background.

    Attributes:
        run: absolute path of the run.
        pid: process ID.
        state: state of the process.
        started: start of the process, seconds since 1970.
    """

    run: Path
    pid: int
    state: RunState
    started: float


def runtime_folder() -> Path:
    """Return the path of the folder for the user's background processes; it may not exist."""
    given = os.environ.get(VARIABLE)
    # os.getuid is missing on Windows, where nothing runs in the background.
    return Path(given) if given else Path("/tmp") / f"gaitsim-{getattr(os, 'getuid', int)()}"


def create_runtime_folder() -> Path:
    """Return the folder for the user's background processes; create it if it is missing."""
    folder = runtime_folder()
    reason = ""
    try:
        with suppress(FileExistsError):
            if folder.is_absolute():
                folder.mkdir(0o700, parents=True)
        reason = _trust_problem(folder)
    except OSError as error:
        reason = f"cannot be created ({error.strerror})"
    if reason:
        raise GaitsimError(
            f"cannot evolve runs in the background: the folder for their processes {reason}",
            where=str(folder),
            allowed="a folder that only you own and can open, with permissions 0700",
            remedy=f"correct it, or set the environment variable {VARIABLE} to another folder",
        )
    return folder


def _trust_problem(folder: Path) -> str:
    """Return why a folder cannot be trusted, without a subject; '' if it can."""
    if not folder.is_absolute():
        return "has a relative path"
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        return "is not a folder"
    if found.st_uid != os.getuid():
        return "belongs to another user"
    return "can be opened by other users" if stat.S_IMODE(found.st_mode) & 0o077 else ""


def runtime_file(run: Path, kind: str, folder: Path | None = None) -> Path:
    """Return the path of a file of a run's background process."""
    key = hashlib.sha256(os.fsencode(os.path.realpath(run))).hexdigest()[:20]
    return (folder or runtime_folder()) / (key + kind)


@contextmanager
def address(path: Path) -> Iterator[str]:
    """Yield an address for a socket's path that is short enough for the operating system."""
    name = os.fspath(path)
    if len(os.fsencode(name)) <= LONGEST_ADDRESS or not sys.platform.startswith("linux"):
        yield name
        return
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)


def status_names(run: Path) -> frozenset[str]:
    """Return the names of the files from which the state of a run's background process is read."""
    return frozenset(runtime_file(run, kind).name for kind in (STATUS, FAILURE))


def runtime_names() -> frozenset[str]:
    """Return the names of all files of background processes."""
    try:
        return frozenset(os.listdir(runtime_folder()))  # noqa: PTH208
    except OSError:
        return frozenset()


def identity(run: Path) -> list[int] | None:
    """Return a key that distinguishes a run folder from a later one at the same path.

    Return None if the folder is missing.
    """
    try:
        found = run.stat()
    except (OSError, ValueError):
        return None
    return [found.st_dev, found.st_ino]


def background_process(run: Path) -> BackgroundProcess | None:
    """Return the background process that evolves a run or waits to; None if there is none."""
    data = _read(runtime_file(run, STATUS))
    return None if data is None else _parse_live_process(data, runtime_file(run, LOCK))


def background_processes() -> list[BackgroundProcess]:
    """Return all processes that evolve runs in the background, sorted by run path."""
    folder = runtime_folder()
    with suppress(OSError):
        found = [
            _parse_live_process(data, path.with_suffix(LOCK))
            for path in folder.glob(f"*{STATUS}")
            if (data := _read(path)) is not None
        ]
        return sorted(filter(None, found), key=lambda process: process.run)
    return []


def last_failure(run: Path) -> GaitsimError | None:
    """Return the error of the run's last background process; None if it did not fail.

    A run that has been evolved since then, in any process, has not failed.
    """
    data = _read(runtime_file(run, FAILURE))
    killed = None if data else _read(runtime_file(run, STATUS))
    if killed is not None and _parse_live_process(killed, runtime_file(run, LOCK)) is None:
        data = {**killed, "error": crash_error(run).to_dict()}
    if data is None or identity(run) not in (data.get("identity"), None):
        return None
    with suppress(KeyError, TypeError, AttributeError):
        return error_from_dict(data["error"])
    return None


def crash_error(run: Path) -> GaitsimError:
    """Return the error of a background process that ended without reporting one."""
    last_line = ""
    with suppress(OSError):
        log = runtime_file(run, LOG)
        with log.open("rb") as file:
            file.seek(max(log.stat().st_size - END_OF_LOG, 0))
            lines = file.read(END_OF_LOG).decode(errors="replace").splitlines()
        last_line = next((line.strip() for line in reversed(lines) if line.strip()), "")
    what = "the run's background process was killed or crashed"
    return RunError(
        f"{what}; its log ends with: {last_line}" if last_line else what,
        where=str(run),
        remedy=f"the run is intact; continue with: {command('resume', run)}",
    )


def forget_failure(run: Path) -> None:
    """Delete the failure of the run's last background process, as the run is evolved again."""
    with suppress(OSError):
        runtime_file(run, FAILURE).unlink(missing_ok=True)
        if runtime_file(run, STATUS).exists():
            from filelock import FileLock

            with FileLock(runtime_file(run, LOCK), timeout=0):  # fails if the process is alive
                for kind in (STATUS, LOG):
                    runtime_file(run, kind).unlink(missing_ok=True)


def check_not_in_background(run: Path, timeout: float = 0.5) -> None:
    """Check that no other process evolves a run in the background, or is waiting to.

    A process that has just closed the run has `timeout` seconds to end.
    """
    end = time.monotonic() + timeout
    while (found := background_process(run)) is not None and found.pid != os.getpid():
        if time.monotonic() >= end:
            raise background_error(run, found)
        time.sleep(0.02)


def background_error(run: Path, found: BackgroundProcess) -> RunError:
    """Return the error of a run that evolves in the background."""
    return RunError(
        f"the run {run} {STATE_PREDICATES[found.state]} in the background, in process {found.pid}",
        remedy=f"watch it: {command('attach', run)}; or stop it: {command('stop', run)}",
    )


def _read(path: Path) -> Mapping[str, Any] | None:
    """Return the object in a runtime file; None if it is missing, damaged or not trusted."""
    try:
        data = read_regular(path, LARGEST)
        found = None if _trust_problem(path.parent) else json.loads(data)
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, Mapping) else None


def _parse_live_process(data: Mapping[str, Any], lock: Path) -> BackgroundProcess | None:
    """Return the process that a status file describes; None if it has ended."""
    match data:
        case {
            "run": str(run),
            "pid": int(pid),
            "state": state,
            "started": float(started),
        } if state in [*STATE_PREDICATES] and is_file_locked(lock):
            return BackgroundProcess(Path(run), pid, state, started)
    return None


def is_file_locked(lock: Path) -> bool:
    """Return whether a process holds the lock of a file; creates no file."""
    try:
        descriptor = open_descriptor(lock, os.O_RDONLY)
    except OSError:
        return False
    try:
        if sys.platform == "win32":
            from filelock import FileLock, Timeout

            try:
                with FileLock(lock, timeout=0):
                    return False
            except Timeout:
                return True
        # As in filelock, but four times as fast; closing the descriptor releases the lock.
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # a file system without locks
        return False
    finally:
        os.close(descriptor)
    return False
