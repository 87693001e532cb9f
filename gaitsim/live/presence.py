"""Files of a background process: lock, socket, state and log."""

import json
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.background import (
    FAILURE,
    LOCK,
    LOG,
    SOCKET,
    STATE_PREDICATES,
    STATUS,
    VARIABLE,
    background_error,
    background_process,
    create_runtime_folder,
    identity,
    runtime_file,
)
from gaitsim.runs.files.folder import deleted_or_moved

BACKLOG = 32  # clients that may wait to be connected
LONGEST_ADDRESS = 100  # bytes; the limit is 104 on macOS, 108 on Linux
LONGEST_LOG = 2**20  # bytes


class Presence:
    """The files that make this process visible to others, until it publishes a final state.

    Args:
        run: folder of the run.

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
                self._write(STATUS, state="preparing", pid=os.getpid())
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
                self._write(STATUS, state=state, pid=os.getpid())

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


def _unusable(folder: Path, error: OSError) -> GaitsimError:
    return GaitsimError(
        f"cannot evolve runs in the background: {error.strerror or error}",
        where=str(folder),
        remedy=f"set the environment variable {VARIABLE} to another folder",
    )
