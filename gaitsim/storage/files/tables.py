"""CSV tables of numbers: a line of names, then one row per generation.

Tables may grow while they are read, and are not trusted.
"""

import csv
import io
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import RunError
from gaitsim.opening import open_regular

LARGEST = 2**30  # bytes of a table, enough for more than two million generations
LONGEST_HEAD = 2**20  # bytes of a table's first line
LONGEST_CELL = 25  # bytes, including the comma, of -2.2250738585072014e-308,
Columns = dict[str, NDArray[np.float64]]
"""Columns of a history by name, each (generations,)."""


def line(cells: Iterable[str | float]) -> str:
    """Return one line of CSV, with numbers in the shortest form that reads back exactly."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(
        [cell if isinstance(cell, str) else repr(cell) for cell in cells]
    )
    return text.getvalue()


def line_ends(path: Path, rows: int) -> list[int]:
    """Return the ends of the first line and the next `rows` lines, in bytes from the start.

    The list is shorter if the file has fewer whole lines, and empty without a file.
    """
    ends: list[int] = []
    with open_records(path) as file:
        start = 0
        while len(ends) <= rows and (data := file.read(2**20)):
            ends += [start + end.end() for end in re.finditer(b"\n", data)]
            start += len(data)
    return ends[: rows + 1]


def first_rows(path: Path, rows: int) -> bytes:
    """Return the first line of a table and at most `rows` whole rows."""
    ends = line_ends(path, rows)
    with open_records(path) as file:
        return file.read(ends[-1] if ends else 0)


def read_head(path: Path, file: BinaryIO) -> bytes:
    """Return the first line of a table; b"" if it is incomplete."""
    head = file.readline(LONGEST_HEAD)
    if len(head) == LONGEST_HEAD:
        raise damaged_error(path, "its first line is too long")
    return head if head.endswith(b"\n") else b""


def read_rows(path: Path, file: BinaryIO, head: bytes, most: int | None) -> bytes:
    """Return the whole lines of a table from the current position.

    The number of columns in the first line, `head`, limits the length of the rows.
    """
    columns = len(column_names(path, head))
    if most == 0:
        return b""
    longest = LARGEST if most is None else most * columns * LONGEST_CELL
    data = read_up_to(file, longest)
    count = data.count(b"\n")
    if 2 * columns * count > len(data) or (len(data) == longest and count < (most or 1)):
        raise damaged_error(path, "a row does not have one number per column")
    if most is not None and count > most:
        ends = (end.end() for end in re.finditer(b"\n", data))
        return data[: next(islice(ends, most - 1, None))]
    return data[: data.rfind(b"\n") + 1]


def read_up_to(file: BinaryIO, most: int) -> bytes:
    """Return at most `most` bytes from the current position.

    The number is limited to the size of the file, as reading allocates the requested size.
    """
    here = file.tell()
    left = file.seek(0, os.SEEK_END) - here
    file.seek(here)
    return file.read(min(most, max(left, 0)))


def column_names(path: Path, head: bytes) -> list[str]:
    """Return the names of a table's columns."""
    try:
        return next(csv.reader([head.decode()]), [])
    except (UnicodeDecodeError, csv.Error):
        raise damaged_error(path, "its first line does not name the columns") from None


def read_table(
    path: Path, most: int | None, parse: Callable[[Path, bytes, bytes], Columns]
) -> Columns:
    """Return the columns of a table by name; {} without a file.

    An incomplete last line, which is still being written, is left out.
    """
    with open_records(path) as file:
        head = read_head(path, file)
        rows = read_rows(path, file, head, most) if head else b""
    return parse(path, head, rows) if head else {}


def parse_rows(
    path: Path, head: bytes, rows: bytes, first: int, check_header: Callable[[list[str]], str]
) -> Columns:
    """Return whole rows of a table as columns by name, each (rows,)."""
    count = rows.count(b"\n")
    names = column_names(path, head)
    if wrong := check_header(names):
        raise damaged_error(path, wrong)
    try:
        # np.loadtxt is three times as fast as csv and float() for a hundred thousand generations.
        table = (
            np.loadtxt(io.BytesIO(rows), delimiter=",", comments=None, ndmin=2, encoding="ascii")
            if count
            else np.empty((0, len(names)))
        )
    except ValueError:
        raise damaged_error(path, "it contains something other than numbers") from None
    if table.shape != (count, len(names)):
        raise damaged_error(path, "a row does not have one number per column")
    if not np.array_equal(table[:, 0], np.arange(first, first + count)):
        raise damaged_error(path, "its rows are not numbered by generation from 1")
    return {name: table[:, column] for column, name in enumerate(names)}


def check_values(
    path: Path, columns: Columns, name: str, accepted: NDArray[np.bool_], allowed: str
) -> None:
    """Check the values of a column."""
    for at in np.flatnonzero(~accepted)[:1]:
        generation = columns["generation"][at]
        raise damaged_error(
            path, f"{name} of generation {generation:.0f} is {columns[name][at]:g}, not {allowed}"
        )


def damaged_error(
    path: Path, reason: str, remedy: str = "restore it from a copy; the checkpoint is not affected"
) -> RunError:
    """Return the error of a damaged file."""
    return RunError(f"{path.name} is damaged: {reason}", where=str(path), remedy=remedy)


@contextmanager
def open_records(path: Path, largest: int = LARGEST) -> Iterator[BinaryIO]:
    """Open a file with one record per generation for reading; a missing file reads as empty."""
    try:
        with ExitStack() as resources:
            try:
                file = resources.enter_context(open_regular(path, largest))
            except FileNotFoundError:
                file = io.BytesIO()
            yield file
    except OSError as error:
        raise RunError(
            f"cannot read {path}: {error.strerror}",
            remedy="restore all files of the run from one copy",
        ) from None
