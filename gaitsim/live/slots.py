"""The queue of background runs: by default, as many evolve at a time as there are cores."""

import os
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import cores

SLOTS_VARIABLE = "GAITSIM_BACKGROUND_RUNS"
FOLDER, GUARD = "queue", "queue.lock"
GUARD_TIMEOUT = 1.0  # seconds to wait while another process changes the queue


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

    Each process draws a ticket, which is a numbered file that it locks. The processes with the
    first `count` locked tickets evolve; the others wait in order.
    """

    def __init__(self, folder: Path, count: int) -> None:
        self._folder, self._count = folder / FOLDER, count
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
                if self._ticket is None:
                    self._ticket = self._draw()
                self._acquired = self._is_first(Path(self._ticket.lock_file).name)
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

    def _draw(self) -> FileLock:
        self._folder.mkdir(0o700, exist_ok=True)
        number = max((int(name) for name in self._tickets()), default=0) + 1
        ticket = FileLock(self._folder / f"{number:012d}")
        ticket.acquire(timeout=0)
        return ticket

    def _tickets(self) -> list[str]:
        return sorted(name for name in os.listdir(self._folder) if name.isdecimal())  # noqa: PTH208

    def _is_first(self, mine: str) -> bool:
        """Return whether a ticket is among the first `count`; remove those of dead processes."""
        before = 0
        for name in self._tickets():
            if name >= mine:
                break
            other = FileLock(self._folder / name)
            try:
                other.acquire(timeout=0)
            except Timeout:
                before += 1
                if before == self._count:
                    return False
            else:
                Path(other.lock_file).unlink(missing_ok=True)
                other.release()
        return True
