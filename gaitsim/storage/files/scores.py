"""`scores.bin`: the scores of all individuals, and the values that the search reads.

A search is a function of its state and these numbers, so that all genomes of a run can be bred
again without moving a body.

Each generation has a block: the number of the bytes that follow, 8 bytes little-endian, then the
numbers of `scores_of`, compressed with zlib (RFC 1950).
"""

import os
import zlib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.evaluation import Evaluation
from gaitsim.storage.files.tables import damaged_error, open_records

COUNT = np.dtype("<i8")
LARGEST = 2**40  # bytes; the file is never read as a whole
MOST_VALUES = 200  # of an individual
FASTEST = 1  # level of zlib: 0.4 ms for 1,000 individuals with 9 numbers each


def scores_of(evaluation: Evaluation) -> bytes:
    """Return the scores, then the values that the search reads, one after the other.

    They are 64-bit floats, little-endian; NaN has a single bit pattern.
    """
    floats = np.concatenate([evaluation.scores, *evaluation.values.values()])
    return np.where(np.isnan(floats), np.nan, floats).astype("<f8").tobytes()


def pack_block(scores: bytes) -> bytes:
    """Return the block of a generation with the bytes of `scores_of`."""
    packed = zlib.compress(scores, FASTEST)
    return np.array(len(packed), COUNT).tobytes() + packed


def block_ends(path: Path, most: int) -> list[int]:
    """Return the ends of at most `most` whole blocks, in bytes from the start of the file."""
    return [*islice(_ends(path), most)]


def _ends(path: Path) -> Iterator[int]:
    with open_records(path, LARGEST) as file:
        size, end = file.seek(0, os.SEEK_END), 0
        while end + COUNT.itemsize <= size:
            file.seek(end)
            count = int(np.frombuffer(file.read(COUNT.itemsize), COUNT)[0])
            end += COUNT.itemsize + count
            if count <= 0 or end > size:
                return
            yield end


def read_block(path: Path, start: int, end: int, individuals: int) -> bytes:
    """Return the bytes of a block, given its place in the file."""
    most = 8 * individuals * MOST_VALUES
    if end - start > COUNT.itemsize + most + most // 1000 + 100:  # zlib adds less
        raise damaged_error(path, f"a generation has {end - start:,} bytes")
    with open_records(path, LARGEST) as file:
        file.seek(start)
        return file.read(end - start)


def unpack_block(path: Path, block: bytes, individuals: int) -> bytes:
    """Return the bytes of `scores_of` in a block."""
    try:
        reader = zlib.decompressobj()
        found = reader.decompress(block[COUNT.itemsize :], 8 * individuals * MOST_VALUES)
    except zlib.error as error:
        raise damaged_error(path, str(error)) from None
    if not reader.eof or reader.unused_data or not found or len(found) % (8 * individuals):
        raise damaged_error(path, f"a generation does not have numbers for {individuals:,}")
    return found


def parse_scores(path: Path, scores: bytes, individuals: int) -> NDArray[np.float64]:
    """Return the numbers of `scores_of`, (1 + values, individuals)."""
    found = np.frombuffer(scores, "<f8").astype(np.float64).reshape(-1, individuals)
    if not (found[0] < np.inf).all():
        raise damaged_error(path, "a score is neither finite nor −inf")
    return found
