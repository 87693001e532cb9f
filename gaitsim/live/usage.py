"""Processor time and memory of the processes that evolve runs."""

import time
from pathlib import Path
from typing import NamedTuple

from gaitsim.storage.background import background_process
from gaitsim.storage.lock import owner_process

_Readings = dict[tuple[int, float], tuple[float, float]]
"""Processor time and time of the last reading, by ID and start of a process, all in seconds."""
_last: dict[Path, _Readings] = {}


class Usage(NamedTuple):
    """The processor time and memory of a run's process and its workers.

    Attributes:
        share: processor time per time since the last reading, or since their start; 1.0 is a core.
        memory: resident memory, in bytes; memory that processes share counts for each.
    """

    share: float
    memory: int


def process_usage(run: Path) -> Usage | None:
    """Return the usage of the process that evolves a run; None without one on this machine."""
    import psutil

    found = background_process(run)
    pid = found.pid if found else owner_process(run)
    before, now = _last.pop(run, {}), time.time()
    share, memory, readings = 0.0, 0, _Readings()
    try:
        main = psutil.Process(pid) if pid else None
        for process in [main, *main.children(recursive=True)] if main else []:
            with process.oneshot():
                times, started = process.cpu_times(), process.create_time()
                memory += process.memory_info().rss
            spent, key = times.user + times.system, (process.pid, started)
            spent_before, at = before.get(key, (0.0, started))
            share += max(spent - spent_before, 0.0) / max(now - at, 0.01)
            readings[key] = spent, now
    except psutil.Error:  # a process has just ended
        return None
    if not readings:
        return None
    _last[run] = readings
    return Usage(share, memory)
