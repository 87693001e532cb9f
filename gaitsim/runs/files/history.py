"""`history.csv`: one row per generation. `bests.bin`: the best genome of each generation.

This module builds and reads their records; `records` writes them.
"""

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import GenomeSpace
from gaitsim.errors import RunError
from gaitsim.evolution import Generation
from gaitsim.opening import open_regular

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
LARGEST = 2**30  # bytes of a table, which are more than two million generations
LARGEST_RECORDS = 2**32  # bytes of a file of records
LONGEST_HEAD = 2**20  # bytes of a table's first line
LONGEST_CELL = 25  # bytes, with the comma: -2.2250738585072014e-308,
Columns = dict[str, NDArray[np.float64]]
"""Columns of a history by name, (generations,) each."""


def row(generation: Generation) -> dict[str, float]:
    """Return a generation's row: score statistics, then terms of the best and their means.

    Failed individuals, with a score of −inf, count for `worst` alone. `std` is the
    standard deviation. The column of a term holds the value of the best individual,
    `mean:<term>` the mean over the individuals that did not fail.
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
        **generation.evaluation.terms_of(best),
        **means,
    }


def island_bests(generation: Generation, islands: int) -> NDArray[np.float64]:
    """Return the best score of each island, (islands,); −inf where all failed."""
    bests: NDArray[np.float64] = generation.scores.reshape(islands, -1).max(axis=1)
    return bests


def islands_record(bests: NDArray[np.float64]) -> bytes:
    """Return the best scores of several islands as their checksum counts them; b"" for one."""
    return bests.astype("<f8").tobytes() if len(bests) > 1 else b""


def islands_header(islands: int) -> tuple[str, ...]:
    """Return the names of the columns of `islands.csv`."""
    return ("generation", *(f"island {number}" for number in range(1, islands + 1)))


def read_islands(path: Path, islands: int, most: int | None = None) -> NDArray[np.float64]:
    """Return the best score of each island by generation, (generations, islands).

    An incomplete last line is being written, and left out, as are rows after the first `most`.

    Raises:
        RunError: the file cannot be read, or is damaged.
    """
    columns = _read_table(path, islands_header(islands), most)
    if columns and len(columns) != 1 + islands:
        raise _damaged(path, f"it does not have a column for each of {islands} islands")
    return np.column_stack([*columns.values()][1:]) if columns else np.empty((0, islands))


def _quartiles(values: NDArray[np.float64]) -> list[float]:
    """Return lower quartile, median and upper quartile, with NumPy's linear interpolation.

    np.quantile takes ten times as long for a hundred values: 150 µs.
    """
    ordered = np.sort(values).tolist()
    found = []
    for part in (0.25, 0.5, 0.75):
        place = part * (len(ordered) - 1)
        below, rest = int(place), place % 1
        low, high = ordered[below], ordered[math.ceil(place)]
        # The difference of two infinities would be NaN.
        found.append(low if low == high else low * (1 - rest) + high * rest)
    return found


def line(cells: Iterable[str | float]) -> str:
    """Return one line of CSV, with numbers in the shortest form that reads back the same."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(
        [cell if isinstance(cell, str) else repr(cell) for cell in cells]
    )
    return text.getvalue()


def header(terms: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a history's columns: general ones, terms, and the terms' means."""
    return (*COLUMNS, *terms, *(MEAN + name for name in terms))


def terms_of(names: Iterable[str]) -> list[str]:
    """Return the terms among the names of a history's columns."""
    more = list(names)[len(COLUMNS) :]
    return more[: len(more) // 2]


def used_terms(columns: Mapping[str, NDArray[np.float64]], present: Sequence[str]) -> list[str]:
    """Return the terms that any stage of a run has or had, in the order of their appearance.

    Columns of a stage that was abandoned before its first generation hold only NaN.

    Args:
        columns: the columns of the history.
        present: the terms of the current stage.
    """
    known = [
        name
        for name in terms_of(columns)
        if name in present
        or not (np.isnan(columns[name]).all() and np.isnan(columns[MEAN + name]).all())
    ]
    return [*known, *(name for name in present if name not in known)]


def line_ends(path: Path, rows: int) -> list[int]:
    """Return the end of the first line of a file and of the next `rows`, in bytes from its start.

    Fewer where there are not as many whole lines; [] without a file.

    Raises:
        RunError: the file cannot be read.
    """
    ends: list[int] = []
    with opened(path) as file:
        start = 0
        while len(ends) <= rows and (data := file.read(2**20)):
            ends += [start + end.end() for end in re.finditer(b"\n", data)]
            start += len(data)
    return ends[: rows + 1]


def first_rows(path: Path, rows: int) -> bytes:
    """Return the first line of a table and at most so many whole rows.

    Raises:
        RunError: the file cannot be read.
    """
    ends = line_ends(path, rows)
    with opened(path) as file:
        return file.read(ends[-1] if ends else 0)


def read_history(path: Path, most: int | None = None) -> Columns:
    """Return the columns of a history by name, each (generations,); {} where there is no file.

    An incomplete last line is being written, and left out, as are rows after the first `most`.

    Raises:
        RunError: the file cannot be read, or is damaged.
    """
    return _read_table(path, COLUMNS, most)


def _read_table(path: Path, columns: Sequence[str], most: int | None) -> Columns:
    with opened(path) as file:
        head = read_head(path, file)
        if not head:
            return {}
        rows = read_rows(path, file, head, most)
    return parse_rows(path, head, rows, columns=columns)


def read_head(path: Path, file: BinaryIO) -> bytes:
    """Return the first line of a table; b"" where it is not whole yet.

    Raises:
        RunError: it is too long to be one.
    """
    head = file.readline(LONGEST_HEAD)
    if len(head) == LONGEST_HEAD:
        raise _damaged(path, "its first line is too long")
    return head if head.endswith(b"\n") else b""


def read_rows(path: Path, file: BinaryIO, head: bytes, most: int | None) -> bytes:
    """Return the whole lines of a table from here on, at most the first `most`.

    Args:
        path: the file, for messages.
        file: the file, opened.
        head: its first line, by which rows that are too long or too short are found unparsed.
        most: the number of lines; None for all.

    Raises:
        RunError: the first line or a row is damaged.
    """
    columns = len(column_names(path, head))
    if most == 0:
        return b""
    longest = LARGEST if most is None else most * columns * LONGEST_CELL
    data = _read(file, longest)
    count = data.count(b"\n")
    if 2 * columns * count > len(data) or (len(data) == longest and count < (most or 1)):
        raise _damaged(path, "a row does not have one number per column")
    if most is not None and count > most:
        ends = (end.end() for end in re.finditer(b"\n", data))
        return data[: next(islice(ends, most - 1, None))]
    return data[: data.rfind(b"\n") + 1]


def _read(file: BinaryIO, most: int) -> bytes:
    """Return at most so many bytes from here on.

    A file reserves memory for all that it is asked for.
    """
    here = file.tell()
    left = file.seek(0, os.SEEK_END) - here
    file.seek(here)
    return file.read(min(most, max(left, 0)))


def column_names(path: Path, head: bytes) -> list[str]:
    """Return the names of a table's columns.

    Raises:
        RunError: the first line is damaged.
    """
    try:
        return next(csv.reader([head.decode()]), [])
    except (UnicodeDecodeError, csv.Error):
        raise _damaged(path, "its first line does not name the columns") from None


def parse_rows(
    path: Path, head: bytes, rows: bytes, first: int = 1, columns: Sequence[str] = COLUMNS
) -> Columns:
    """Return whole rows of a table as columns by name, (rows,) each.

    Args:
        path: the file, for messages.
        head: its first line.
        rows: whole lines of it.
        first: the generation of the first row.
        columns: the names that its first line begins with.

    Raises:
        RunError: the first line or a row is damaged.
    """
    count = rows.count(b"\n")
    names = column_names(path, head)
    if tuple(names[: len(columns)]) != tuple(columns):
        raise _damaged(path, "its first line does not name the columns")
    try:
        # Three times as fast as csv and float() for a hundred thousand generations.
        table = (
            np.loadtxt(io.StringIO(rows.decode()), delimiter=",", comments=None, ndmin=2)
            if count
            else np.empty((0, len(names)))
        )
    except ValueError:
        raise _damaged(path, "it contains something other than numbers") from None
    if table.shape != (count, len(names)):
        raise _damaged(path, "a row does not have one number per column")
    if not np.array_equal(table[:, 0], np.arange(first, first + count)):
        raise _damaged(path, "its rows are not those of the generations from 1 on")
    return {name: table[:, column] for column, name in enumerate(names)}


def _damaged(path: Path, reason: str) -> RunError:
    return RunError(
        f"{path.name} is damaged: {reason}",
        where=str(path),
        remedy="restore it from a copy; the checkpoint beside it is separate",
    )


@contextmanager
def opened(path: Path, largest: int = LARGEST) -> Iterator[BinaryIO]:
    """Open a file with one record per generation for reading; a missing one is empty.

    Raises:
        RunError: it cannot be read.
    """
    try:
        with ExitStack() as held:
            try:
                file = held.enter_context(open_regular(path, largest))
            except FileNotFoundError:
                file = io.BytesIO()
            yield file
    except OSError as error:
        raise RunError(
            f"cannot read {path}: {error.strerror}",
            remedy="restore all files of the run from one copy",
        ) from None


def best_terms(columns: Mapping[str, NDArray[np.float64]], generation: int) -> dict[str, float]:
    """Return the terms of the best score of a generation.

    Terms of other stages, which are NaN there, are left out.
    """
    found = {name: float(columns[name][generation - 1]) for name in terms_of(columns)}
    return {name: value for name, value in found.items() if not math.isnan(value)}


def record_type(space: GenomeSpace) -> np.dtype[Any]:
    """Return the layout of one record of `bests.bin`: score, then genome, little-endian."""
    return np.dtype([("score", "<f8"), ("genome", space.dtype.newbyteorder("<"), (space.genes,))])


def read_records(path: Path, layout: np.dtype[Any], most: int | None = None) -> NDArray[Any]:
    """Return the records of a file with one per generation; none where there is no file.

    An incomplete last record is being written, and left out, as are records after the first `most`.

    Raises:
        RunError: the file cannot be read.
    """
    with opened(path, LARGEST_RECORDS) as file:
        data = _read(file, LARGEST_RECORDS if most is None else most * layout.itemsize)
    return np.frombuffer(data, layout, count=len(data) // layout.itemsize)
