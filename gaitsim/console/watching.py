"""`gaitsim runs --watch`: the evolving runs of a folder with their speed and load."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from rich.live import Live
from rich.table import Table
from rich.text import Text

from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import output, print_json
from gaitsim.live.protocol import Speed
from gaitsim.live.slots import queued_runs
from gaitsim.render.terminal.text import duration, number, visible
from gaitsim.storage.background import background_process
from gaitsim.storage.growing import RunsWatcher
from gaitsim.storage.lock import owner_process
from gaitsim.storage.overview import Overview
from gaitsim.storage.query import Query

PERIOD = 1.0  # seconds between two updates
RECENT = 10.0  # seconds over which speeds are measured
COLUMNS = ("run", "state", "generation", "best", "gen./s", "left", "CPU", "memory")

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


def watch(
    root: Path, query: Query, *, json: bool, sleep: Callable[[float], object] = time.sleep
) -> None:
    """Show the evolving, queued and paused runs of a folder until Ctrl-C.

    Without a terminal, print them once. With JSON, print a line for each run every second, until
    none evolves.

    Args:
        root: folder that holds the runs.
        query: query that the runs match.
        json: whether to print JSON.
        sleep: function that waits for a number of seconds.
    """
    watcher, console = RunsWatcher(root), output()
    speeds: dict[Path, Speed] = {}

    def poll() -> list[dict[str, Any]]:
        runs = [run for run in query.select(watcher.poll()) if run.evolves]
        queue = queued_runs()
        return [_values(run, queue, speeds.setdefault(run.path, Speed(RECENT))) for run in runs]

    try:
        with interruptible():
            if json:
                while rows := poll():
                    for row in rows:
                        print_json({"time": time.time(), **row})
                    sleep(PERIOD)
            elif not console.is_terminal:
                console.print(_table(poll()))
            else:
                with Live(_table(poll()), console=console, auto_refresh=False) as live:
                    while True:
                        sleep(PERIOD)
                        live.update(_table(poll()), refresh=True)
    except KeyboardInterrupt:
        return


def _values(run: Overview, queue: list[Path], speed: Speed) -> dict[str, Any]:
    """Return the current values of a run."""
    if run.state == "running":
        speed.add(run.generation, run.evaluations)
    else:
        speed.clear()
    rate = speed.per_second()["generations_per_second"]
    usage, path = process_usage(run.path), run.path.resolve()
    return {
        "run": run.name,
        "state": run.state,
        "queue_position": queue.index(path) + 1 if path in queue else None,
        "generation": run.generation,
        "generations": run.generations,
        "best": run.best,
        "generations_per_second": rate,
        "seconds_left": (run.generations - run.generation) / rate if rate else None,
        "cpu_percent": 100 * usage.share if usage else None,
        "memory_bytes": usage.memory if usage else None,
    }


def _table(rows: list[dict[str, Any]]) -> Table | Text:
    if not rows:
        return Text("No run is evolving.")
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in COLUMNS:
        right = name not in ("run", "state")
        # In a narrow terminal, only the names are clipped.
        table.add_column(name, justify="right" if right else "left", no_wrap=name != "run")
    for row in rows:
        rate, left, memory = row["generations_per_second"], row["seconds_left"], row["memory_bytes"]
        table.add_row(
            Text(visible(row["run"]), no_wrap=True, overflow="ellipsis"),
            f"{row['state']} {row['queue_position'] or ''}".rstrip(),
            f"{row['generation']}/{row['generations']}",
            "" if row["best"] is None else number(row["best"], 4),
            f"{rate:.2g}" if rate else "",
            duration(left) if left is not None else "",
            "" if row["cpu_percent"] is None else f"{row['cpu_percent']:.0f} %",
            "" if memory is None else f"{memory / 1e6:,.0f} MB",
        )
    return table
