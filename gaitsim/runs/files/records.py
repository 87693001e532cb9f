"""The files of a run that get a record a generation: history, bests, islands and checksums."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Self

import numpy as np

from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment
from gaitsim.runs.files import history
from gaitsim.runs.files.append_only import (
    AppendOnlyFile,
    AppendOnlyHistory,
    AppendOnlyIslands,
    padded,
)
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.checksums import RECORD, checksums
from gaitsim.runs.files.folder import BESTS, CHECKSUMS, HISTORY, ISLANDS, ends_early


class RecordFiles:
    """The record files of a run, open for appending; a context manager.

    Args:
        path: the run's folder.
        experiment: of the run.
        done: the number of generations to keep; the records after them are dropped.

    Raises:
        RunError: a file holds fewer records, or cannot be written.
    """

    def __init__(self, path: Path, experiment: Experiment, done: int) -> None:
        self._layout = history.record_type(experiment.space())
        self._number = number = experiment.islands.number
        rows, bests, islands = path / HISTORY, path / BESTS, path / ISLANDS
        lines = history.line_ends(rows)
        islands_lines = history.line_ends(islands) if number > 1 else []
        stored = {
            HISTORY: max(len(lines) - 1, 0),
            ISLANDS: max(len(islands_lines) - 1, 0) if number > 1 else done,
            BESTS: bests.stat().st_size // self._layout.itemsize if bests.exists() else 0,
        }
        for name, count in stored.items():
            if count < done:
                raise ends_early(path, name, count, done)
        kept = done + 1 if done else 0
        with ExitStack() as held, writing(path):
            self._history = AppendOnlyHistory(rows, lines[:kept])
            held.callback(self._history.close)
            self._bests = AppendOnlyFile(bests, done * self._layout.itemsize)
            held.callback(self._bests.close)
            self._islands = AppendOnlyIslands(islands, number, islands_lines[:kept])
            held.callback(self._islands.close)
            self._checksums = padded(path / CHECKSUMS, done, RECORD.itemsize)
            held.callback(self._checksums.close)
            self._held = held.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()

    def append(self, generation: Generation, row: Mapping[str, float]) -> None:
        """Add the records of a generation, whose row of the history is `row`."""
        best = generation.best
        record = np.zeros((), self._layout)
        record["score"], record["genome"] = generation.scores[best], generation.genomes[best]
        islands = history.island_bests(generation, self._number)
        kept = record.tobytes() + history.islands_record(islands)
        self._history.append(row)
        self._bests.append(record.tobytes())
        self._islands.append(generation.number, islands)
        # Not forced to disk, which would take as long as everything else here. If a power cut
        # loses one, only `gaitsim verify` misses it.
        self._checksums.append(
            checksums(generation.genomes, generation.evaluation, row, kept), force=False
        )
