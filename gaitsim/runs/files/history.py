"""`history.csv`: one row a generation. `bests.bin`: each generation's best genome.

How rows are made and both files read; `growing` writes them.
"""

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import GenomeSpace
from gaitsim.errors import RunError
from gaitsim.evolution import Generation

COLUMNS = (
    "generation",
    "stage",
    "evaluations",
    "best",
    "mean",
    "median",
    "lower quartile",
    "upper quartile",
    "worst",
    "std",
    "diversity",
    "seconds",
)
MEAN = "mean:"
Columns = dict[str, NDArray[np.float64]]
"""Columns of a history by name, (generations,) each."""


def row(generation: Generation) -> dict[str, float]:
    """A generation's row: statistics of the scores, then terms of the best and their means.

    Failed individuals, with a score of −inf, count for `worst` alone. `std` is the
    standard deviation. A term's own column is that of the best individual, `mean:<term>`
    the mean over the individuals that did not fail.
    """
    scores = generation.scores
    alive = np.isfinite(scores)
    finite = scores[alive] if alive.any() else scores
    lower, median, upper = _quartiles(finite)
    best = generation.best
    terms = generation.evaluation.terms
    means = {
        MEAN + name: float(values[alive].mean()) if alive.any() else float("nan")
        for name, values in terms.items()
    }
    return {
        "generation": generation.number,
        "stage": generation.progress.stage,
        "evaluations": generation.progress.evaluations,
        "best": float(scores[best]),
        "mean": float(finite.mean()),
        "median": median,
        "lower quartile": lower,
        "upper quartile": upper,
        "worst": float(scores.min()),
        "std": float(finite.std()) if alive.any() else 0.0,
        "diversity": generation.diversity,
        "seconds": generation.seconds,
        **{name: float(values[best]) for name, values in terms.items()},
        **means,
    }


def island_bests(generation: Generation, islands: int) -> NDArray[np.float64]:
    """The best score of each island in a generation, (islands,); −inf where all failed."""
    bests: NDArray[np.float64] = generation.scores.reshape(islands, -1).max(axis=1)
    return bests


def islands_record(bests: NDArray[np.float64]) -> bytes:
    """The bests of several islands as their checksum counts them; of one, nothing."""
    return bests.astype("<f8").tobytes() if len(bests) > 1 else b""


def islands_header(islands: int) -> tuple[str, ...]:
    """The names of the columns of `islands.csv`."""
    return ("generation", *(f"island {number}" for number in range(1, islands + 1)))


def read_islands(path: Path, islands: int) -> NDArray[np.float64]:
    """The best score of each island by generation, (generations, islands); (0, islands) before any.

    A last line that is not whole is one that is being written, and left out.

    Raises:
        RunError: it cannot be read, or a row is damaged.
    """
    data = _read(path)
    head, *rows = data[: data.rfind(b"\n") + 1].split(b"\n")[:-1] or [b""]
    if not head and not rows:
        return np.empty((0, islands))
    wrong = _damaged(path, f"it does not hold a row of numbers a generation for {islands} islands")
    if head.decode(errors="replace") != ",".join(islands_header(islands)) or not all(rows):
        raise wrong
    if not rows:
        return np.empty((0, islands))
    try:
        table = np.loadtxt([row.decode() for row in rows], delimiter=",", comments=None, ndmin=2)
    except (UnicodeDecodeError, ValueError):
        raise wrong from None
    numbers = np.arange(1, len(rows) + 1)
    if table.shape != (len(rows), 1 + islands) or not np.array_equal(table[:, 0], numbers):
        raise wrong
    return table[:, 1:]


def _quartiles(values: NDArray[np.float64]) -> list[float]:
    """Lower quartile, median and upper quartile, linear between neighbours as NumPy's.

    A tenth of what np.quantile takes for a hundred values: 15 µs.
    """
    ordered = np.sort(values).tolist()
    found = []
    for part in (0.25, 0.5, 0.75):
        place = part * (len(ordered) - 1)
        below, rest = int(place), place % 1
        low, high = ordered[below], ordered[math.ceil(place)]
        # Of equals, such as −inf of a generation in which all failed, there is no mean.
        found.append(low if low == high else low * (1 - rest) + high * rest)
    return found


def line(cells: Iterable[str | float]) -> str:
    """One line of CSV; numbers in the shortest form that reads back the same."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(
        [cell if isinstance(cell, str) else repr(cell) for cell in cells]
    )
    return text.getvalue()


def header(terms: Sequence[str]) -> tuple[str, ...]:
    """The names of a history's columns: the general ones, a term each, a term's mean each."""
    return (*COLUMNS, *terms, *(MEAN + name for name in terms))


def terms_of(names: Iterable[str]) -> list[str]:
    """The terms among the names of a history's columns."""
    more = list(names)[len(COLUMNS) :]
    return more[: len(more) // 2]


def used_terms(columns: Mapping[str, NDArray[np.float64]], present: Sequence[str]) -> list[str]:
    """The terms that some stage of a run has or had, in the order in which they came.

    Columns of a stage that was given up before its first generation hold no number.

    Args:
        columns: of the history.
        present: the terms of the stage that the run is in.
    """
    known = [
        name
        for name in terms_of(columns)
        if name in present
        or not (np.isnan(columns[name]).all() and np.isnan(columns[MEAN + name]).all())
    ]
    return [*known, *(name for name in present if name not in known)]


def line_ends(path: Path) -> list[int]:
    """Where each whole line of a file ends, in bytes from its start; [] where there is no file.

    Raises:
        RunError: it cannot be read.
    """
    return [end.end() for end in re.finditer(b"\n", _read(path))]


def read_header(path: Path) -> tuple[str, ...]:
    """The names of a history's columns; () where there is no whole line yet.

    Raises:
        RunError: it cannot be read, or is no text.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            first = file.readline()
        return tuple(next(csv.reader([first]))) if first.endswith("\n") else ()
    except FileNotFoundError:
        return ()
    except (UnicodeDecodeError, csv.Error):
        raise _damaged(path, "its first line is no text") from None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}") from None


def read_history(path: Path) -> dict[str, NDArray[np.float64]]:
    """Return the columns of a history by name, each (generations,); {} where there is no file.

    A last line that is not whole is being written, and left out.

    Raises:
        RunError: it cannot be read, or a row is damaged.
    """
    data = _read(path)
    head = data.find(b"\n") + 1
    return parse_rows(path, data[:head], data[head : data.rfind(b"\n") + 1]) if head else {}


def parse_rows(path: Path, head: bytes, rows: bytes, first: int = 1) -> Columns:
    """Return whole rows of a history as columns by name, (rows,) each.

    Args:
        path: the file, for messages.
        head: its first line.
        rows: whole lines of it.
        first: the generation of the first row.

    Raises:
        RunError: a row is damaged.
    """
    count = rows.count(b"\n")
    try:
        names = next(csv.reader([head.decode()]))
        # Three times as fast as csv and float() for a hundred thousand generations.
        table = (
            np.loadtxt(io.StringIO(rows.decode()), delimiter=",", comments=None, ndmin=2)
            if count
            else np.empty((0, len(names)))
        )
    except (UnicodeDecodeError, csv.Error, ValueError, StopIteration):
        raise _damaged(path, "a row does not hold numbers alone") from None
    if table.shape != (count, len(names)):
        raise _damaged(path, "a row does not hold as many numbers as there are columns")
    if tuple(names[: len(COLUMNS)]) != COLUMNS:
        raise _damaged(path, "its first line does not name the columns of a history")
    if not np.array_equal(table[:, 0], np.arange(first, first + count)):
        raise _damaged(path, "its rows are not those of the generations from 1 on")
    return {name: table[:, column] for column, name in enumerate(names)}


def _damaged(path: Path, reason: str) -> RunError:
    return RunError(
        f"{path.name} is damaged: {reason}",
        where=str(path),
        remedy="restore it from a copy; the checkpoint beside it is separate",
    )


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return b""
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}") from None


def best_terms(columns: Mapping[str, NDArray[np.float64]], generation: int) -> dict[str, float]:
    """The terms of the best score of a generation, out of a history's columns.

    Only those that have a number: another stage's terms have none.
    """
    found = {name: float(columns[name][generation - 1]) for name in terms_of(columns)}
    return {name: value for name, value in found.items() if not math.isnan(value)}


def record_type(space: GenomeSpace) -> np.dtype[Any]:
    """The layout of one record of `bests.bin`: score, then genome, little-endian."""
    return np.dtype([("score", "<f8"), ("genome", space.dtype.newbyteorder("<"), (space.genes,))])


def read_bests(path: Path, space: GenomeSpace) -> NDArray[Any]:
    """Every generation's best: a structured array with `score` and `genome`.

    Raises:
        RunError: it cannot be read.
    """
    return read_records(path, record_type(space))


def read_records(path: Path, layout: np.dtype[Any]) -> NDArray[Any]:
    """The records of a file that has one a generation; none where there is no file.

    A last record that is not whole is one that is being written, and left out.

    Raises:
        RunError: it cannot be read.
    """
    data = _read(path)
    return np.frombuffer(data, layout, count=len(data) // layout.itemsize)
