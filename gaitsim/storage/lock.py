"""The lock of a run folder: only one process at a time writes to a run."""

import errno
import os
import re
import socket
from contextlib import suppress
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import open_descriptor, read_regular
from gaitsim.storage.background import check_not_in_background, is_file_locked

TIMEOUT = 0.5  # seconds; `is_locked` also holds the lock for a moment
_REMOVE = "remove the lock, if no process writes the run"
_REMEDIES = dict.fromkeys((errno.ELOOP, errno.EINVAL, errno.EISDIR, errno.EMLINK), _REMOVE)


class RunLock:
    """The lock of a run folder; the system releases it however the process ends."""

    def __init__(self, folder: Path) -> None:
        from filelock import FileLock, Timeout

        check_not_in_background(folder, TIMEOUT)
        self._lock = FileLock(folder / ".lock")
        owner = folder / ".lock-owner"
        try:
            # filelock would also open other kinds of files.
            os.close(open_descriptor(folder / ".lock", os.O_RDWR | os.O_CREAT))
            self._lock.acquire(timeout=TIMEOUT, poll_interval=0.02)
        except Timeout:
            raise RunError(
                f"the run {folder} is being written by {_read(owner)}",
                remedy="wait until it ends, or stop it with Ctrl-C; the run is saved",
            ) from None
        except OSError as error:
            raise RunError(
                f"cannot lock the run {folder}: {error.strerror}",
                where=str(folder / ".lock"),
                remedy=_REMEDIES.get(
                    error.errno or 0, "check that the folder exists and is writable"
                ),
            ) from None
        # The name of the owner is only for messages.
        with suppress(OSError):
            owner.unlink(missing_ok=True)  # it could be a link
            with owner.open("x", encoding="utf-8") as file:
                file.write(f"process {os.getpid()} on {socket.gethostname()}")

    def release(self) -> None:
        """Unlock the run."""
        with suppress(OSError):  # a plugin closed its descriptor, which unlocked the run
            self._lock.release()


def _read(owner: Path) -> str:
    try:
        return read_regular(owner, 1000).decode()[:200] or "another process"
    except (OSError, UnicodeDecodeError):
        return "another process"


def owner_process(folder: Path) -> int | None:
    """Return the ID of the process on this machine that writes a run; None without one."""
    found = re.fullmatch(r"process (\d{1,10}) on (.*)", _read(folder / ".lock-owner"))
    if found is None or found[2] != socket.gethostname() or not is_locked(folder):
        return None
    return int(found[1])


def is_locked(folder: Path) -> bool:
    """Return whether a process is writing the run."""
    return is_file_locked(folder / ".lock")
