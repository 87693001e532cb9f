"""`digests.bin`: of each generation, digests by which it is seen that it came out the same again.

They find what was damaged or changed by mistake, and name its generation. They prove nothing
of who wrote them: only evolving again does.
"""

import hashlib
import math
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Genomes
from gaitsim.evaluation import Evaluation
from gaitsim.runs.files.history import read_records

SIZE = 32
RECORD = np.dtype([(part, f"V{SIZE}") for part in ("genomes", "scores", "row")])
"""SHA-256 of the genomes, of scores and terms, and of the generation's row and best."""

NONE = bytes(SIZE)
"""Stands where no digest was written: by a gaitsim that wrote none."""


def digests(
    genomes: Genomes, evaluation: Evaluation, row: Mapping[str, float], bests: bytes
) -> bytes:
    """The record of a generation.

    Args:
        genomes: (population, genes).
        evaluation: of these.
        row: of the history.
        bests: its record in `bests.bin`, then each island's best where there are several.
    """
    return of_genomes(genomes) + of_scores(evaluation) + of_row(row, bests)


def of_genomes(genomes: Genomes) -> bytes:
    """The digest of a population, (population, genes)."""
    return hashlib.sha256(repr(genomes.shape).encode() + _little(genomes)).digest()


def of_scores(evaluation: Evaluation) -> bytes:
    """The digest of scores and terms."""
    digest = hashlib.sha256(_little(evaluation.scores))
    for name, values in evaluation.terms.items():
        digest.update(name.encode() + b"\0" + _little(values))
    return digest.digest()


def of_row(row: Mapping[str, float], bests: bytes) -> bytes:
    """The digest of a row of the history, its time left out, and of what is kept of the bests.

    Numbers that are none are left out, too: another stage's terms are such columns.
    """
    cells = {
        name: value
        for name, value in sorted(row.items())
        if name != "seconds" and not math.isnan(value)
    }
    digest = hashlib.sha256(bests)
    digest.update("\0".join(cells).encode())
    digest.update(struct.pack(f"<{len(cells)}d", *cells.values()))
    return digest.digest()


def read_digests(path: Path) -> NDArray[Any]:
    """Every generation's record; none where there is no file.

    Raises:
        RunError: it cannot be read.
    """
    return read_records(path, RECORD)


def _little(values: Array) -> bytes:
    """The bytes of an array, little-endian, all that is no number alike."""
    if values.dtype.kind == "f" and np.isnan(values).any():
        values = np.where(np.isnan(values), np.nan, values)
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
