"""What the benchmarks share: medians, ratios, and the load of the machine."""

import os
import statistics
import time
from collections.abc import Callable

ROUNDS = 5


def medians(*works: Callable[[], object], repeats: int) -> list[float]:
    """The median time of each of `works`, seconds, called so often in each of five rounds.

    They take turns, round by round, so that whatever else the machine does slows all of
    them alike. The first call of a round finds the caches filled by others; it does not count.
    """
    taken: list[list[float]] = [[] for _ in works]
    for _ in range(ROUNDS):
        for work, seconds in zip(works, taken, strict=True):
            work()
            seconds += [stopwatch(work) for _ in range(repeats)]
    return [statistics.median(seconds) for seconds in taken]


def stopwatch(work: Callable[[], object]) -> float:
    """How long `work` takes, seconds."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def milliseconds(seconds: float) -> str:
    """Such as '1.74 ms' or '2.69 s'."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{1000 * seconds:.3g} ms"


def times(ratio: float) -> str:
    """Such as '3.1 ×' or '1,300 ×'."""
    return f"{ratio:,.0f} ×" if ratio >= 100 else f"{ratio:.2g} ×"


def print_machine() -> None:
    """How many cores there are, and how many programs want one: figures are for an idle machine."""
    busy = f", load {os.getloadavg()[0]:.1f} before the start" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores{busy}\n")


def print_figure(what: str, figure: str, beside: str = "") -> None:
    """One aligned line."""
    print(f"{what:<52} {figure:>12}  {beside}".rstrip())
