"""Functions shared by the benchmarks: timing, formats, and the load of the machine."""

import os
import platform
import re
import statistics
import time
from collections.abc import Callable
from pathlib import Path

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
    """Format a ratio, such as "1.75 ×" or "1,300 ×"."""
    return f"{ratio:,.0f} ×" if ratio >= 100 else f"{ratio:.3g} ×"


def print_machine() -> None:
    """Print the number of cores and the load; figures are meaningful on an idle machine only."""
    busy = f", load {os.getloadavg()[0]:.1f} before the start" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores, {processor()}{busy}\n")


def processor() -> str:
    """Return the name of the processor, and whether it has AVX-512."""
    try:
        facts = Path("/proc/cpuinfo").read_text()
    except OSError:
        return platform.processor() or platform.machine()
    name = re.search(r"^model name\s*: (.*)", facts, re.MULTILINE)
    return (name[1] if name else platform.machine()) + (
        " with AVX-512" if "avx512f" in facts else ""
    )


def print_budget(
    what: str, measured: float, budget: float, form: Callable[[float], str], *, least: bool = False
) -> None:
    """Print a figure beside its budget.

    Args:
        what: label of the figure.
        measured: the figure.
        budget: largest value, or smallest if `least` is true.
        form: function that formats the figure and the budget.
        least: whether larger values are better.
    """
    held = measured >= budget if least else measured <= budget
    verdict = "" if held else "  OVER BUDGET"
    bound = "at least" if least else "at most"
    print_figure(what, form(measured), f"budget: {bound} {form(budget)}{verdict}")


def print_figure(what: str, figure: str, beside: str = "") -> None:
    """Print a label, a figure and a remark on one aligned line."""
    print(f"{what:<52} {figure:>12}  {beside}".rstrip())
