"""The files of a run with one record per generation: history, bests, islands and checksums."""

import os
from collections.abc import Mapping
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Self

import numpy as np

from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment
from gaitsim.runs.files import history
from gaitsim.runs.files.append_only import AppendOnlyFile, AppendOnlyHistory
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.checksums import NONE, RECORD, SIZE, checksums
from gaitsim.runs.files.folder import BESTS, CHECKSUMS, HISTORY, ISLANDS, truncation_error
from gaitsim.runs.files.tables import line, line_ends, open_records


class RecordFiles:
    """The record files of a run, open for appending; a context manager.

    Args:
        path: folder of the run.
        experiment: experiment of the run.
        done: number of generations to keep; later records are dropped.
    """

    def __init__(self, path: Path, experiment: Experiment, done: int) -> None:
        self._layout = history.record_type(experiment.space())
        self._number = number = experiment.islands.number
        tables = (HISTORY, ISLANDS) if number > 1 else (HISTORY,)
        ends = {name: line_ends(path / name, done) for name in tables}
        stored = {name: max(len(found) - 1, 0) for name, found in ends.items()}
        bests = path / BESTS
        with open_records(bests, history.LARGEST_RECORDS) as file:
            stored[BESTS] = file.seek(0, os.SEEK_END) // self._layout.itemsize
        for name, count in stored.items():
            if count < done:
                raise truncation_error(path, name, count, done)
        keep = {name: found[done] if done else 0 for name, found in ends.items()}
        size = RECORD.itemsize
        with ExitStack() as held, writing(path):
            self._history = held.enter_context(
                closing(AppendOnlyHistory(path / HISTORY, keep[HISTORY]))
            )
            self._bests = held.enter_context(
                closing(AppendOnlyFile(bests, done * self._layout.itemsize))
            )
            # Zeros replace checksums lost in a power failure.
            self._checksums = held.enter_context(
                closing(AppendOnlyFile(path / CHECKSUMS, done * size, size))
            )
            self._chain = self._checksums.last(SIZE) if done else NONE
            if number > 1:
                self._islands = held.enter_context(
                    closing(AppendOnlyFile(path / ISLANDS, keep[ISLANDS]))
                )
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
        bests = record.tobytes() + history.islands_record(islands)
        self._history.append(row)
        self._bests.append(record.tobytes())
        if self._number > 1:
            row_of_islands = line([generation.number, *islands.tolist()])
            self._islands.append(row_of_islands.encode())
        record_of_checksums = checksums(
            generation.genomes, generation.evaluation, row, bests, self._chain
        )
        self._checksums.append(record_of_checksums)
        self._chain = record_of_checksums[-SIZE:]

    def flush(self) -> None:
        """Write the records added since the last call, and flush them to disk."""
        self._history.flush()
        self._bests.flush()
        if self._number > 1:
            self._islands.flush()
        # Not forced to the disk: if a power failure loses a checksum, only `gaitsim verify`
        # misses it.
        self._checksums.flush(force=False)
