"""The queue of background runs: by default, as many evolve at a time as there are cores.

Each process draws a ticket, a file in the folder `queue` that it locks: NUMBER-KEY, with the key of
its run in the folder of background processes. The runs with the lowest numbers evolve, the others
wait. A ticket is only drawn or removed while a guard is locked; tickets that no process locks are
ignored and removed.
"""

import os
import re
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import cores
from gaitsim.storage.background import (
    background_processes,
    is_file_locked,
    runtime_file,
    runtime_folder,
)

SLOTS_VARIABLE = "GAITSIM_BACKGROUND_RUNS"
FOLDER, GUARD = "queue", "queue.lock"
GUARD_TIMEOUT = 1.0  # seconds to wait while another process changes the queue
_TICKET = re.compile(r"(\d{12})(?:-([0-9a-f]{20}))?")


def slot_count() -> int:
    """Return the maximum number of background runs that evolve at a time."""
    given = os.environ.get(SLOTS_VARIABLE)
    if not given:
        return cores()
    if given.isascii() and given.isdecimal() and int(given[:9]) >= 1:
        return int(given[:9])
    raise GaitsimError(
        f"invalid number of parallel runs: {given!r}",
        where=f"environment variable {SLOTS_VARIABLE}",
        allowed="a whole number, 1 or more; if unset, the number of cores",
    )


class Slot:
    """A permit to evolve at the same time as up to `count` − 1 other runs.

    Args:
        folder: folder of background processes.
        count: maximum number of runs that evolve at a time.
        run: folder of the run.
    """

    def __init__(self, folder: Path, count: int, run: Path) -> None:
        self._folder, self._count = folder / FOLDER, count
        self._key = runtime_file(run, "").name
        self._guard = FileLock(folder / GUARD)
        self._ticket: FileLock | None = None
        self._acquired = False

    def try_acquire(self) -> bool:
        """Return whether this run may evolve; the first call draws a ticket.

        On a full or broken file system, every run may evolve.
        """
        if self._acquired:
            return True
        try:
            with self._guard.acquire(timeout=GUARD_TIMEOUT):
                self._acquired = self._is_first(self._draw())
        except Timeout:
            return False
        except OSError:
            self._acquired = True
        return self._acquired

    def release(self) -> None:
        """Free the slot for the next run; a later `try_acquire` draws a new ticket."""
        self._acquired = False
        if self._ticket is not None:
            with suppress(OSError):
                Path(self._ticket.lock_file).unlink(missing_ok=True)
                self._ticket.release()
            self._ticket = None

    def _draw(self) -> Path:
        """Return the ticket of this run; draw one at first, or if its file was deleted."""
        if self._ticket is not None and Path(self._ticket.lock_file).exists():
            return Path(self._ticket.lock_file)
        if self._ticket is not None:
            self._ticket.release()
        self._folder.mkdir(0o700, exist_ok=True)
        number = max((int(path.name[:12]) for path in _tickets(self._folder)), default=0) + 1
        path = self._folder / f"{number:012d}-{self._key}"
        self._ticket = FileLock(path)
        self._ticket.acquire(timeout=0)
        return path

    def _is_first(self, mine: Path) -> bool:
        """Return whether a ticket is among the first `count`; remove those of dead processes."""
        before = 0
        for path in _tickets(self._folder):
            if path.name >= mine.name:
                break
            if is_file_locked(path):
                before += 1
                if before == self._count:
                    return False
            else:
                path.unlink(missing_ok=True)
        return True


def queued_runs() -> list[Path]:
    """Return the runs that wait in the queue, the next one first."""
    waiting = (process.run for process in background_processes() if process.state == "queued")
    runs = {runtime_file(run, "").name: run for run in waiting}
    tickets = _tickets(runtime_folder() / FOLDER)
    keys = (path.name.partition("-")[2] for path in tickets if is_file_locked(path))
    return [runs[key] for key in keys if key in runs]


def _tickets(folder: Path) -> list[Path]:
    """Return the tickets in order; [] without a folder."""
    with suppress(FileNotFoundError):
        names = os.listdir(folder)  # noqa: PTH208
        return [folder / name for name in sorted(names) if _TICKET.fullmatch(name)]
    return []
