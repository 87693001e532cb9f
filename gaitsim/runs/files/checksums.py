"""`checksums.bin`: checksums of each generation, by which `gaitsim verify` finds changes.

Each record's last checksum covers the rest of the record, the generation's row and best, and the
last checksum of the record before. So a change of any of these shows, and in which generation. That
does not prove who wrote the run: only evolving it again does.
"""

import hashlib
import math
import struct
from collections.abc import Mapping

import numpy as np

from gaitsim.contracts import Array, Genomes
from gaitsim.evaluation import Evaluation

SIZE = 32
RECORD = np.dtype([(part, f"V{SIZE}") for part in ("genomes", "scores", "chain")])
"""SHA-256 of the genomes, of scores and terms, and of all that the chain covers."""

NONE = bytes(SIZE)
"""Marks a generation without a checksum."""


def checksums(
    genomes: Genomes,
    evaluation: Evaluation,
    row: Mapping[str, float],
    bests: bytes,
    before: bytes,
) -> bytes:
    """Return the record of a generation.

    Args:
        genomes: (population, genes).
        evaluation: of these.
        row: of the history.
        bests: its record in `bests.bin`, then each island's best where there are several.
        before: the chain's checksum of the generation before; NONE where there is none.
    """
    parts = genomes_checksum(genomes) + scores_checksum(evaluation)
    return parts + chain_checksum(before, parts, row, bests)


def genomes_checksum(genomes: Genomes) -> bytes:
    """Return the checksum of a population, (population, genes)."""
    return hashlib.sha256(repr(genomes.shape).encode() + _little(genomes)).digest()


def scores_checksum(evaluation: Evaluation) -> bytes:
    """Return the checksum of scores and terms."""
    digest = hashlib.sha256(_little(evaluation.scores))
    for name, values in evaluation.terms.items():
        digest.update(name.encode() + b"\0" + _little(values))
    return digest.digest()


def chain_checksum(before: bytes, parts: bytes, row: Mapping[str, float], bests: bytes) -> bytes:
    """Return the checksum of a generation's record, and of the chain before it.

    The row's time is left out, as is NaN: columns of another stage's terms hold it.

    Args:
        before: the chain's checksum of the generation before; NONE where there is none.
        parts: the checksums of genomes and scores.
        row: of the history.
        bests: its record in `bests.bin`, then each island's best where there are several.
    """
    cells = {
        name: value
        for name, value in sorted(row.items())
        if name != "seconds" and not math.isnan(value)
    }
    digest = hashlib.sha256(before + parts + bests)
    digest.update("\0".join(cells).encode())
    digest.update(struct.pack(f"<{len(cells)}d", *cells.values()))
    return digest.digest()


def _little(values: Array) -> bytes:
    """Return the bytes of an array, little-endian, with all NaN alike."""
    if values.dtype.kind == "f" and np.isnan(values).any():
        values = np.where(np.isnan(values), np.nan, values)
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
