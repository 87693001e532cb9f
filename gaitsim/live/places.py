"""The queue of runs in the background: as many evolve at a time as there are cores."""

import os
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import cores

VARIABLE = "GAITSIM_BACKGROUND_RUNS"
FOLDER, GUARD = "queue", "queue.lock"
GUARDED = 1.0  # seconds to wait for another process


def places() -> int:
    """Return the maximum number of runs that evolve in the background at a time.

    Raises:
        GaitsimError: the environment variable has an invalid value.
    """
    given = os.environ.get(VARIABLE)
    if not given:
        return cores()
    if given.isascii() and given.isdecimal() and int(given[:9]) >= 1:
        return int(given[:9])
    raise GaitsimError(
        f"invalid number of parallel runs: {given!r}",
        where=f"environment variable {VARIABLE}",
        allowed="a whole number, 1 or more; if unset, the number of cores",
    )


class Place:
    """A place among the runs that evolve at the same time.

    A process draws a ticket, a file that it locks. The runs of the first `count` tickets of living
    processes evolve; the others wait in order.

    Args:
        folder: private folder of the background processes.
        count: maximum number of runs that evolve at a time.
    """

    def __init__(self, folder: Path, count: int) -> None:
        self._folder, self._count = folder / FOLDER, count
        self._guard = FileLock(folder / GUARD)
        self._ticket: FileLock | None = None
        self._taken = False

    def take(self) -> bool:
        """Return whether this run may evolve; the first call draws a ticket.

        On a full or broken file system, runs do not wait.
        """
        if self._taken:
            return True
        try:
            with self._guard.acquire(timeout=GUARDED):
                if self._ticket is None:
                    self._ticket = self._draw()
                self._taken = self._first(Path(self._ticket.lock_file).name)
        except Timeout:
            return False
        except OSError:
            self._taken = True
        return self._taken

    def leave(self) -> None:
        """Free the place for the next run; a later `take` queues again."""
        self._taken = False
        if self._ticket is not None:
            with suppress(OSError):
                Path(self._ticket.lock_file).unlink(missing_ok=True)
                self._ticket.release()
            self._ticket = None

    def _draw(self) -> FileLock:
        self._folder.mkdir(0o700, exist_ok=True)
        number = max((int(name) for name in self._names()), default=0) + 1
        ticket = FileLock(self._folder / f"{number:012d}")
        ticket.acquire(timeout=0)
        return ticket

    def _names(self) -> list[str]:
        return sorted(name for name in os.listdir(self._folder) if name.isdecimal())  # noqa: PTH208

    def _first(self, mine: str) -> bool:
        """Return whether the ticket is among the first `count`; remove those of dead processes."""
        before = 0
        for name in self._names():
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
