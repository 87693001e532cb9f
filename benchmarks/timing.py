"""Functions shared by the benchmarks: timing, formats, and the load of the machine."""

import os
import statistics
import time
from collections.abc import Callable

ROUNDS = 5


def medians(*works: Callable[[], object], repeats: int) -> list[float]:
    """Return the median time of each of `works`, seconds, over `repeats` calls in five rounds.

    The functions take turns, so that other programs slow all of them alike. The first call of a
    round is not measured, because the other functions have evicted its data from the caches.
    """
    taken: list[list[float]] = [[] for _ in works]
    for _ in range(ROUNDS):
        for work, seconds in zip(works, taken, strict=True):
            work()
            seconds += [stopwatch(work) for _ in range(repeats)]
    return [statistics.median(seconds) for seconds in taken]


def stopwatch(work: Callable[[], object]) -> float:
    """Call `work`, and return the seconds."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def milliseconds(seconds: float) -> str:
    """Format a duration, such as '1.74 ms' or '2.69 s'."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{1000 * seconds:.3g} ms"


def times(ratio: float) -> str:
    """Format a ratio, such as '3.1 ×' or '1,300 ×'."""
    return f"{ratio:,.0f} ×" if ratio >= 100 else f"{ratio:.2g} ×"


def print_machine() -> None:
    """Print the number of cores and the load; figures are meaningful on an idle machine only."""
    busy = f", load {os.getloadavg()[0]:.1f} before the start" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores{busy}\n")


def print_figure(what: str, figure: str, beside: str = "") -> None:
    """Print a label, a figure and a remark on one aligned line."""
    print(f"{what:<52} {figure:>12}  {beside}".rstrip())
