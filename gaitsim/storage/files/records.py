"""The files of a run that grow: its records by generation, and saves.

They are truncated to the checkpoint when a run resumes.

With `checksums.bin`, `gaitsim verify` finds changes: the last checksum of each record covers the
rest of the record, the generation's row, best individual and scores, and the last checksum of the
previous record. It therefore reveals any change, and the generation that was changed. It does not
prove that the scores are genuine: only reproducing the run does.

`saves.bin` lists the generation of each save, and is written before everything else in it. After a
crash, the checkpoint is of the last save or of the one before it. An older one was put there.
"""

import hashlib
import math
import os
import struct
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import Self

import numpy as np

from gaitsim.contracts import Array, Genomes
from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment
from gaitsim.opening import open_descriptor
from gaitsim.storage.files import history
from gaitsim.storage.files.atomic import write_bytes, writing
from gaitsim.storage.files.folder import (
    ALL_SCORES,
    BESTS,
    CHECKSUMS,
    HISTORY,
    ISLANDS,
    SAVES,
    truncation_error,
)
from gaitsim.storage.files.history import (
    WHOLE,
    figures_of,
    header,
    header_problem,
    parse_history,
    read_history,
    read_records,
    terms_of,
    used_terms,
)
from gaitsim.storage.files.scores import block_ends, pack_block, scores_of
from gaitsim.storage.files.tables import (
    Columns,
    damaged_error,
    line,
    line_ends,
    open_records,
    read_head,
)

SIZE = 32
RECORD = np.dtype([(part, f"V{SIZE}") for part in ("genomes", "scores", "chain")])
"""SHA-256 hashes of the genomes, of scores and terms, and of everything in the chain."""

NONE = bytes(SIZE)
"""Marks a generation without a checksum."""

SAVE = np.dtype("<i8")
"""The generation of a save."""


def genomes_checksum(genomes: Genomes) -> bytes:
    """Return the checksum of a population, (population, genes)."""
    return hashlib.sha256(repr(genomes.shape).encode() + _little(genomes)).digest()


def scores_checksum(evaluation: Evaluation) -> bytes:
    """Return the checksum of scores and terms."""
    digest = hashlib.sha256(_little(evaluation.scores))
    for name, values in evaluation.terms.items():
        digest.update(name.encode() + b"\0" + _little(values))
    return digest.digest()


def chain_checksum(before: bytes, parts: bytes, row: Mapping[str, float], others: bytes) -> bytes:
    """Return the checksum of a generation's record and of the chain before it.

    It omits the time in the row, and NaN, which fills the columns of other stages' terms.

    Args:
        before: chain checksum of the previous generation; NONE without one.
        parts: checksums of genomes and scores.
        row: row of the history.
        others: record in `bests.bin`, the best score of each of several islands, and the numbers in
            `scores.bin`.
    """
    cells = {
        name: value
        for name, value in sorted(row.items())
        if name != "seconds" and not math.isnan(value)
    }
    digest = hashlib.sha256(before + parts + others)
    digest.update("\0".join(cells).encode())
    digest.update(struct.pack(f"<{len(cells)}d", *cells.values()))
    return digest.digest()


def _little(values: Array) -> bytes:
    """Return the bytes of an array, little-endian, with a single bit pattern for NaN."""
    if values.dtype.kind == "f" and np.isnan(values).any():
        values = np.where(np.isnan(values), np.nan, values)
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


class AppendOnlyFile:
    """A file that grows by whole records, and is truncated when opened.

    Records are gathered in memory until `flush`.

    Args:
        path: path of the file.
        keep: number of bytes to keep; a shorter file is extended with zeros, from its last whole
            record.
        size: size of a record, bytes.
    """

    def __init__(self, path: Path, keep: int, size: int = 1) -> None:
        self._path = path
        self._open(keep, size)

    def _open(self, keep: int, size: int = 1) -> None:
        self._gathered = bytearray()
        with writing(self._path):
            self._descriptor = open_descriptor(self._path, os.O_RDWR | os.O_CREAT)
        whole = os.fstat(self._descriptor).st_size // size * size
        os.ftruncate(self._descriptor, min(whole, keep))
        os.ftruncate(self._descriptor, keep)
        os.lseek(self._descriptor, 0, os.SEEK_END)

    def append(self, data: bytes) -> None:
        """Add a record."""
        self._gathered += data

    def flush(self) -> None:
        """Write the gathered records, and flush them to disk."""
        try:
            opened = os.fstat(self._descriptor)
        except OSError as error:
            raise RunError(
                f"cannot write {self._path.name}: a plugin closed its descriptor",
                where=str(self._path),
                remedy="change the plugin to close only files that it opened",
            ) from error
        if not self._is_in_place(opened):
            raise RunError(
                f"{self._path.name} was deleted or replaced while the run was being written",
                where=str(self._path),
                remedy="do not change the files of a run before it has ended; copy them instead",
            )
        data, self._gathered = self._gathered, bytearray()
        with memoryview(data) as view:
            written = 0
            while written < len(view):
                written += os.write(self._descriptor, view[written:])
        os.fsync(self._descriptor)

    def _is_in_place(self, opened: os.stat_result) -> bool:
        try:
            return os.path.samestat(opened, self._path.lstat())
        except OSError:
            return False

    def last(self, size: int) -> bytes:
        """Return the last bytes of the file."""
        os.lseek(self._descriptor, -size, os.SEEK_END)
        return os.read(self._descriptor, size)

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        if self._descriptor >= 0:
            with suppress(OSError):  # a plugin may have closed it
                os.close(self._descriptor)
        self._descriptor = -1


class AppendOnlyHistory(AppendOnlyFile):
    """A run's `history.csv`, opened for writing.

    New terms of a stage get columns of their own, which are `nan` in the rows of other stages.
    """

    def __init__(self, path: Path, keep: int) -> None:
        super().__init__(path, keep)
        self._terms: list[str] | None = None  # terms of the rows written by this process
        self._columns: tuple[str, ...] = ()

    def append_row(self, values: Mapping[str, float]) -> None:
        """Add a generation's row, as returned by `history.row`."""
        terms = terms_of(values)
        head = ""
        if terms != self._terms:
            head = self._prepare(terms, figures_of(values))
        row = line([values.get(name, math.nan) for name in self._columns])
        self.append((head + row).encode())
        self._terms = terms

    def _prepare(self, terms: Sequence[str], figures: Sequence[str]) -> str:
        """Add missing columns for terms and figures to the file.

        Returns:
            The header, to be written first, if the file is empty; otherwise ''.
        """
        with open_records(self._path) as file:
            head = read_head(self._path, file)
        self._columns = header(terms, figures)
        if not head:
            return line(self._columns)
        found = tuple(parse_history(self._path, head, b""))
        if found == self._columns:
            return ""
        before = read_history(self._path)
        self._columns = header(used_terms(before, terms), figures)
        if wrong := header_problem(self._columns):
            raise damaged_error(self._path, wrong)
        if found != self._columns:
            # Closed first, as some systems cannot replace open files.
            self.close()
            data = _table(before, self._columns).encode()
            write_bytes(self._path, data, follow=False)
            self._open(len(data))
        return ""


def _table(before: Columns, columns: Sequence[str]) -> str:
    """Return the text of a history with the given columns; missing values are `nan`."""
    missing = [math.nan] * len(before["generation"])
    cells: list[list[float]] = []
    for name in columns:
        values = before[name].tolist() if name in before else missing
        cells.append([int(value) for value in values] if name in WHOLE else values)
    return "".join([line(columns), *map(line, zip(*cells, strict=True))])


class RecordFiles:
    """The record files of a run, open for appending; a context manager.

    Records after generation `done` are dropped.
    """

    def __init__(self, path: Path, experiment: Experiment, done: int) -> None:
        self._layout = history.record_type(experiment.space())
        self._number = number = experiment.islands.number
        tables = (HISTORY, ISLANDS) if number > 1 else (HISTORY,)
        ends = {name: line_ends(path / name, done) for name in tables}
        stored = {name: max(len(found) - 1, 0) for name, found in ends.items()}
        with open_records(path / BESTS, history.LARGEST_RECORDS) as file:
            stored[BESTS] = file.seek(0, os.SEEK_END) // self._layout.itemsize
        blocks = block_ends(path / ALL_SCORES, done)
        stored[ALL_SCORES] = len(blocks)
        for name, count in stored.items():
            if count < done:
                raise truncation_error(path, name, count, done)
        keep = {name: found[done] if done else 0 for name, found in ends.items()}
        size = RECORD.itemsize
        with ExitStack() as held, writing(path):

            def opened(name: str, keep: int, size: int = 1) -> AppendOnlyFile:
                return held.enter_context(closing(AppendOnlyFile(path / name, keep, size)))

            self._history = held.enter_context(
                closing(AppendOnlyHistory(path / HISTORY, keep[HISTORY]))
            )
            self._bests = opened(BESTS, done * self._layout.itemsize)
            self._scores = opened(ALL_SCORES, blocks[-1] if done else 0)
            self._checksums = opened(CHECKSUMS, done * size, size)
            saves = read_records(path / SAVES, SAVE)
            kept = int((saves <= done).sum()) * SAVE.itemsize
            self._saves = opened(SAVES, kept, SAVE.itemsize)
            self._chain = self._checksums.last(SIZE) if done else NONE
            if number > 1:
                self._islands = opened(ISLANDS, keep[ISLANDS])
                if not done:
                    self._islands.append(line(history.islands_header(number)).encode())
            self._held = held.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()

    def append(self, generation: Generation, row: Mapping[str, float]) -> None:
        """Add the records of a generation, whose row in the history is `row`, until `flush`."""
        best = generation.best
        record = np.zeros((), self._layout)
        record["score"], record["genome"] = generation.scores[best], generation.genomes[best]
        islands = history.island_bests(generation, self._number)
        self._last = generation.number
        scores = scores_of(generation.evaluation)
        others = record.tobytes() + history.islands_record(islands) + scores
        self._history.append_row(row)
        self._bests.append(record.tobytes())
        self._scores.append(pack_block(scores))
        if self._number > 1:
            row_of_islands = line([generation.number, *islands.tolist()])
            self._islands.append(row_of_islands.encode())
        parts = genomes_checksum(generation.genomes) + scores_checksum(generation.evaluation)
        self._chain = chain_checksum(self._chain, parts, row, others)
        self._checksums.append(parts + self._chain)

    def flush(self) -> None:
        """Write the records added since the last call, and flush them to disk."""
        self._saves.append(np.array(self._last, SAVE).tobytes())
        self._saves.flush()
        self._history.flush()
        self._bests.flush()
        self._scores.flush()
        if self._number > 1:
            self._islands.flush()
        self._checksums.flush()
