"""`history.csv`: one row a generation. `bests.bin`: each generation's best genome.

Both only ever grow by whole records; on resuming they are cut back to the checkpoint.
"""

import csv
import io
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import GenomeSpace
from gaitsim.errors import RunError
from gaitsim.evolution import Generation

COLUMNS = (
    "generation",
    "evaluations",
    "best",
    "mean",
    "median",
    "worst",
    "spread",
    "diversity",
    "seconds",
)
MEAN = "mean "


def row(generation: Generation) -> dict[str, float]:
    """A generation's row: statistics of the scores, then terms of the best and their means.

    Failed individuals, with a score of −inf, count for `worst` alone. `spread` is the
    standard deviation. A term's own column is that of the best individual, `mean <term>`
    the mean over the individuals that did not fail.
    """
    scores = generation.scores
    alive = np.isfinite(scores)
    finite = scores[alive] if alive.any() else scores
    best = generation.best
    terms = generation.evaluation.terms
    means = {
        MEAN + name: float(values[alive].mean()) if alive.any() else float("nan")
        for name, values in terms.items()
    }
    return {
        "generation": generation.number,
        "evaluations": generation.progress.evaluations,
        "best": float(scores[best]),
        "mean": float(finite.mean()),
        "median": float(np.median(finite)),
        "worst": float(scores.min()),
        "spread": float(finite.std()) if alive.any() else 0.0,
        "diversity": generation.diversity,
        "seconds": generation.seconds,
        **{name: float(values[best]) for name, values in terms.items()},
        **means,
    }


def line(values: Mapping[str, float] | tuple[str, ...]) -> str:
    """One line of CSV; numbers in the shortest form that reads back the same."""
    cells = values if isinstance(values, tuple) else [repr(value) for value in values.values()]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def line_ends(path: Path) -> list[int]:
    """Where each whole line of a file ends, in bytes from its start; [] where there is no file.

    Raises:
        RunError: it cannot be read.
    """
    return [end.end() for end in re.finditer(b"\n", _read(path))]


def read_history(path: Path) -> dict[str, NDArray[np.float64]]:
    """The columns of a history by name, each (generations,); empty where there is no file.

    A last line that is not whole is one that is being written, and left out.

    Raises:
        RunError: it cannot be read, or a row is damaged.
    """
    data = _read(path)
    data = data[: data.rfind(b"\n") + 1]
    if not data:
        return {}
    rows = data.count(b"\n") - 1
    try:
        text = io.StringIO(data.decode())
        header = next(csv.reader([text.readline()]))
        # Three times as fast as csv and float() for a hundred thousand generations.
        table = (
            np.loadtxt(text, delimiter=",", comments=None, ndmin=2)
            if rows
            else np.empty((0, len(header)))
        )
    except (UnicodeDecodeError, csv.Error, ValueError):
        raise _damaged(path, "a row does not hold numbers alone") from None
    if table.shape != (rows, len(header)):
        raise _damaged(path, "a row does not hold as many numbers as there are columns")
    if tuple(header[: len(COLUMNS)]) != COLUMNS:
        raise _damaged(path, "its first line does not name the columns of a history")
    if not np.array_equal(table[:, 0], np.arange(1, rows + 1)):
        raise _damaged(path, "its rows are not those of the generations from 1 on")
    return {name: table[:, column] for column, name in enumerate(header)}


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
    """The terms of the best score of a generation, out of a history's columns."""
    more = list(columns)[len(COLUMNS) :]  # a column a term, then a mean a term
    return {name: float(columns[name][generation - 1]) for name in more[: len(more) // 2]}


def record_type(space: GenomeSpace) -> np.dtype[Any]:
    """The layout of one record of `bests.bin`: score, then genome, little-endian."""
    return np.dtype([("score", "<f8"), ("genome", space.dtype.newbyteorder("<"), (space.genes,))])


def read_bests(path: Path, space: GenomeSpace) -> NDArray[Any]:
    """Every generation's best: a structured array with `score` and `genome`.

    A last record that is not whole is one that is being written, and left out.

    Raises:
        RunError: it cannot be read.
    """
    data = _read(path)
    layout = record_type(space)
    return np.frombuffer(data, layout, count=len(data) // layout.itemsize)


class Growing:
    """A file that grows by whole records and can be cut back."""

    def __init__(self, path: Path, keep: int) -> None:
        """Open `path` for appending after its first `keep` bytes."""
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        os.ftruncate(self._descriptor, keep)
        os.lseek(self._descriptor, 0, os.SEEK_END)

    def append(self, data: bytes) -> None:
        """Add a record and force it to disk."""
        view = memoryview(data)
        while view:
            view = view[os.write(self._descriptor, view) :]
        os.fsync(self._descriptor)

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)
