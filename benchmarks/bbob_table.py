"""Tables of BBOB's results: areas under the ECDF of runtimes, by dimension and kind of function."""

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import fmean
from typing import Any

Row = dict[str, Any]
KINDS = {
    "separable": 5,
    "moderate": 9,
    "ill-conditioned": 14,
    "multimodal": 19,
    "weak structure": 24,
}
"""Group of functions in the suite -> number of its last function."""


def rows(path: Path) -> Iterator[Row]:
    """Yield the saved results."""
    if path.exists():
        yield from map(json.loads, path.read_text().splitlines())


def key(row: Row) -> tuple[str, int, int, int]:
    """Return the key of a result: search, dimension, function, instance."""
    return row["search"], row["dimension"], row["function"], row["instance"]


def area(row: Row, budget: int, targets: int) -> float:
    """Return the area under the ECDF of one result's runtimes, 0 to 1."""
    logs = (1 - math.log(max(hit / row["dimension"], 1), budget) for hit in row["hits"])
    return sum(logs) / targets


def print_tables(path: Path, budget: int, targets: int) -> None:
    """Print areas by dimension and by kind of function, and processor times.

    Only problems with a result of every search in the file count.
    """
    results = {key(row): row for row in rows(path)}
    names = list(dict.fromkeys(name for name, *_ in results))
    shared = {problem for _, *problem in map(tuple, results) for problem in [tuple(problem)]}
    shared = {problem for problem in shared if all((name, *problem) in results for name in names)}
    counted = [row for row in results.values() if key(row)[1:] in shared]
    print(f"{len(shared)} problems; area under the ECDF\n")
    dimensions = sorted({row["dimension"] for row in counted})
    _print(
        counted, names, lambda row: str(row["dimension"]), [*map(str, dimensions)], budget, targets
    )
    _print(counted, names, _kind, list(KINDS), budget, targets)


def _kind(row: Row) -> str:
    return next(kind for kind, last in KINDS.items() if row["function"] <= last)


def _print(
    counted: list[Row],
    names: list[str],
    column: Callable[[Row], str],
    columns: list[str],
    budget: int,
    targets: int,
) -> None:
    print("| search | " + " | ".join(columns) + " | all | processor time |")
    print("| --- |" + (len(columns) + 2) * " --- |")
    for name in names:
        own = [row for row in counted if row["search"] == name]
        parts = [[row for row in own if column(row) == each] for each in columns] + [own]
        means = [
            fmean(area(row, budget, targets) for row in part) if part else 0.0 for part in parts
        ]
        seconds = sum(row["seconds"] for row in own)
        print(
            f"| {name} | " + " | ".join(f"{mean:.3f}" for mean in means) + f" | {seconds:.0f} s |"
        )
    print()
