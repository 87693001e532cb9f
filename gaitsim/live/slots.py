"""The queue of background runs: by default, as many evolve at a time as there are cores.

Each process draws a ticket, a file in the folder `queue` that it locks: NUMBER-KEY, with the key of
its run in the folder of background processes. The ticket of an evolving run has the number 0, and
waiting runs start in the order of their numbers. The queue is only changed while its guard is
locked; tickets that no process locks are ignored and removed.
"""

import os
import re
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation.executors import cores
from gaitsim.storage.background import (
    background_processes,
    create_runtime_folder,
    is_file_locked,
    runtime_file,
    runtime_folder,
)
from gaitsim.storage.files.atomic import writing

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
        self._key = _key(run)
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
                mine = self._find() if self._ticket else None
                if mine is None:
                    mine = self._draw()
                if self._is_first(mine):
                    mine.rename(_ticket(self._folder, 0, self._key))
                    self._acquired = True
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
                # A ticket that is renamed meanwhile is removed by the next process.
                if mine := self._find():
                    mine.unlink(missing_ok=True)
                self._ticket.release()
            self._ticket = None

    def _draw(self) -> Path:
        self._folder.mkdir(0o700, exist_ok=True)
        while left := self._find():  # by a killed process of this run
            left.unlink()
        if self._ticket is not None:  # another program has deleted its file
            self._ticket.release()
        number = max((_number(path) for path in _tickets(self._folder)), default=0) + 1
        path = _ticket(self._folder, number, self._key)
        ticket = FileLock(path)
        ticket.acquire(timeout=0)
        self._ticket = ticket
        return path

    def _find(self) -> Path | None:
        """Return the ticket of this run, which may have been moved; None if it was removed."""
        mine = (path for path in _tickets(self._folder) if path.name.endswith(f"-{self._key}"))
        return next(mine, None)

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
    return [run for _, run in _waiting(runtime_folder() / FOLDER)]


def move_queued(run: Path, to: int) -> list[Path]:
    """Move a run in the queue, and return the runs that wait, the next one first.

    Args:
        run: folder of the run.
        to: new place, counted from 0; negative ones count from the end, as in a list.

    Raises:
        RunError: the run does not wait in the queue, or the queue cannot be changed.
    """
    folder = create_runtime_folder()
    try:
        with FileLock(folder / GUARD).acquire(timeout=GUARD_TIMEOUT), writing(folder / FOLDER):
            waiting = _waiting(folder / FOLDER)
            runs = [one for _, one in waiting]
            mine = next((one for one in runs if _key(one) == _key(run)), None)
            if mine is None:
                raise RunError(
                    f"the run {run} does not wait in the queue",
                    allowed=", ".join(map(str, runs)) or "none; no run waits",
                )
            runs.remove(mine)
            runs.insert(to if to >= 0 else len(runs) + 1 + to, mine)
            tickets = {_key(one): ticket for ticket, one in waiting}
            for (place, _), one in zip(waiting, runs, strict=True):
                key = _key(one)
                tickets[key].rename(_ticket(folder / FOLDER, _number(place), key))
            return runs
    except Timeout:
        raise RunError(
            "another process is changing the queue", where=str(folder), remedy="try again"
        ) from None


def _waiting(folder: Path) -> list[tuple[Path, Path]]:
    """Return the tickets of live waiting processes, with their runs, in order."""
    runs = {_key(process.run): process.run for process in background_processes()}
    return [
        (path, runs[key])
        for path in _tickets(folder)
        if _number(path) and (key := path.name.partition("-")[2]) in runs and is_file_locked(path)
    ]


def _tickets(folder: Path) -> list[Path]:
    """Return the tickets in order; [] without a folder."""
    with suppress(FileNotFoundError):
        names = os.listdir(folder)  # noqa: PTH208
        return [folder / name for name in sorted(names) if _TICKET.fullmatch(name)]
    return []


def _ticket(folder: Path, number: int, key: str) -> Path:
    return folder / f"{number:012d}-{key}"


def _number(ticket: Path) -> int:
    return int(ticket.name[:12])


def _key(run: Path) -> str:
    return runtime_file(run, "").name
