"""`checksums.bin`: checksums of each generation, with which `gaitsim verify` finds changes.

The last checksum of each record covers the rest of the record, the generation's row and best
individual, and the last checksum of the previous record. It therefore reveals any change, and the
generation that was changed.
It does not prove that the scores are genuine: only reproducing the run does.
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
"""SHA-256 hashes of the genomes, of scores and terms, and of everything in the chain."""

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

    See `chain_checksum`.
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
    """Return the checksum of a generation's record and of the chain before it.

    It omits the time in the row, and NaN, which fills the columns of other stages' terms.

    Args:
        before: chain checksum of the previous generation; NONE without one.
        parts: checksums of genomes and scores.
        row: row of the history.
        bests: record in `bests.bin`, followed by the best score of each of several islands.
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
    """Return the bytes of an array, little-endian, with a single bit pattern for NaN."""
    if values.dtype.kind == "f" and np.isnan(values).any():
        values = np.where(np.isnan(values), np.nan, values)
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
