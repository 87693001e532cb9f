"""Files of a process that evolves a run in the background: lock, socket, state and log."""

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
    STATUS,
    background_process,
    identity,
    in_background,
    make_runtime_folder,
    runtime_file,
)

WAITING = 32  # backlog of connecting clients
LONGEST_ADDRESS = 100  # bytes; 104 on macOS, 108 on Linux
LONGEST_LOG = 2**20  # bytes


class Presence:
    """Makes this process visible to others, from the start until a state that ends it.

    Args:
        run: folder of the run that this process evolves.

    Attributes:
        listener: listening socket.

    Raises:
        GaitsimError: the private folder cannot be used.
        RunError: another process evolves the run in the background, or its folder is gone.
    """

    def __init__(self, run: Path) -> None:
        folder = make_runtime_folder()
        self._run = run
        self._path, self._identity = os.path.realpath(run), identity(run)
        self._files = {
            kind: runtime_file(run, kind, folder) for kind in (STATUS, FAILURE, LOCK, SOCKET, LOG)
        }
        self._state = ""
        self._lock = FileLock(self._files[LOCK])
        try:
            # With a timeout, as checks for a living process hold the lock briefly.
            self._lock.acquire(timeout=0.5, poll_interval=0.02)
        except Timeout:
            found = background_process(run)
            raise (
                in_background(run, found)
                if found
                else RunError(
                    f"the run {run} is being started in the background", remedy="try again"
                )
            ) from None
        except OSError as error:
            raise _unusable(folder, error) from None
        with ExitStack() as undone:
            undone.callback(self._leave, None)
            self.check()
            self.listener = undone.enter_context(socket.socket(socket.AF_UNIX))
            try:
                self._files[SOCKET].unlink(missing_ok=True)  # left by a killed process
                with address(self._files[SOCKET]) as name:
                    self.listener.bind(name)
                self.listener.listen(WAITING)
                self._write(STATUS, state="preparing", pid=os.getpid())
            except OSError as error:
                raise _unusable(folder, error) from None
            undone.pop_all()

    def check(self) -> None:
        """Check that the run's folder still exists.

        Raises:
            RunError: it was deleted, moved or replaced.
        """
        if self._identity is None or identity(self._run) != self._identity:
            raise RunError(
                f"the folder of the run {self._run} was deleted or moved while it was evolved",
                remedy="start a new run, or resume this one in its new place",
            )

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

    def tend(self) -> None:
        """Shorten the log, and touch the files, as temporary folders are cleared of old ones."""
        with suppress(OSError):
            if os.fstat(2).st_size > LONGEST_LOG:
                os.ftruncate(2, 0)
        for path in self._files.values():
            with suppress(OSError):
                os.utime(path)
        with suppress(OSError):
            os.utime(self._files[LOCK].parent)

    def note(self, state: str, error: GaitsimError | None = None) -> None:
        """Publish a state; one that ends the process also removes its files."""
        if state == self._state:
            return
        self._state = state
        if state in ("finished", "stopped", "failed"):
            self._leave(error)
        else:
            with suppress(OSError):
                self._write(STATUS, state=state, pid=os.getpid())

    def _leave(self, error: GaitsimError | None) -> None:
        with suppress(OSError):
            self._files[SOCKET].unlink(missing_ok=True)
            # If the error cannot be stored, others at least see that the process has ended.
            if error is not None:
                self._write(FAILURE, error=error.to_dict())
            for kind in (STATUS, LOG):
                self._files[kind].unlink(missing_ok=True)
        with suppress(OSError):
            # A process that waits for the lock of a removed file then locks a new file.
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
    """Yield an address for a socket's path that is short enough for the system."""
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
        f"runs cannot evolve in the background: {error.strerror or error}",
        where=str(folder),
        remedy="set the environment variable GAITSIM_RUNTIME_DIR to another folder",
    )
