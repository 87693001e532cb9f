"""A study on disk, cell by cell: stopped at any time, gone on with at the finished cell."""

import hashlib
import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator, Executor
from gaitsim.evaluation.executors import WorkerLostError, cores
from gaitsim.evaluation.processes import OnWarning, ProcessExecutor
from gaitsim.evolution.repeats import evolve_repeats
from gaitsim.experiment import Experiment
from gaitsim.runs.files.atomic import write_bytes, writing
from gaitsim.study.file import Cell

CELLS = "cells"

Best = NDArray[np.float64]
"""Best score so far, (repeats, recorded generations)."""


def recorded(experiment: Experiment, every: int) -> NDArray[np.int64]:
    """The generations that are put down: every so many, and the last."""
    last = experiment.evolution.generations
    numbers = np.arange(every, last + 1, every)
    return numbers if len(numbers) and numbers[-1] == last else np.append(numbers, last)


def run_cell(experiment: Experiment, repeats: int, every: int) -> Best:
    """Repeat one experiment; a run of G generations has all smaller numbers in it."""
    kept = set(recorded(experiment, every).tolist())
    with Evaluator(experiment, 1) as evaluator:
        best = [
            generation.best
            for generation in evolve_repeats(experiment, evaluator.evaluate, repeats)
            if generation.number in kept
        ]
    return np.stack(best, axis=1)


def finished(folder: Path, cell: Cell, repeats: int, every: int) -> Best | None:
    """The result of a cell that is done; None of one that is not, or is damaged."""
    shape = (repeats, len(recorded(cell.experiment, every)))
    size = 8 * math.prod(shape)
    try:
        data = _file(folder, cell).read_bytes()
    except OSError:
        return None
    whole = io.BytesIO()
    np.save(whole, np.zeros(shape), allow_pickle=False)
    head = whole.getvalue()[:-size]
    # Its head is known to the last byte: nothing of a damaged file need be understood.
    if len(data) != len(head) + size or not data.startswith(head):
        return None
    best = np.frombuffer(data, np.float64, offset=len(head)).reshape(shape)
    return None if np.isnan(best).any() else best


def run_cells(
    folder: Path,
    cells: Sequence[Cell],
    repeats: int,
    every: int,
    workers: int | None,
    on_warning: OnWarning = lambda text: None,
    cluster: Executor | None = None,
) -> Iterator[Cell]:
    """Run cells over worker processes and write each as it is done; yields those done.

    Whoever stops iterating ends the workers; what is not written is run again next time.

    Args:
        folder: of the study.
        cells: what to run.
        repeats: of each.
        every: so many generations are recorded.
        workers: how many; None for as many as there are cores.
        on_warning: called with a message for the user when workers died.
        cluster: workers elsewhere, instead; whoever made it ends it.

    Raises:
        GaitsimError: a cell fails, or ends its workers again and again, or a result cannot
            be written.
    """
    with writing(folder):
        (folder / CELLS).mkdir(exist_ok=True)
    # The longest first, so that no core is left with it at the end.
    ordered = sorted(cells, key=lambda cell: -_work(cell.experiment))
    tasks = [(cell.experiment, repeats, every) for cell in ordered]
    own = (
        ProcessExecutor(min(workers or cores(), max(1, len(cells))), on_warning)
        if cluster is None
        else None
    )
    executor = cluster or own
    assert executor is not None
    try:
        executor.check(cell.experiment for cell in ordered)
        for place, best in executor.each(_run_cell, tasks):
            file = io.BytesIO()
            np.save(file, best, allow_pickle=False)
            write_bytes(_file(folder, ordered[place]), file.getvalue())
            yield ordered[place]
    except WorkerLostError as error:
        raise GaitsimError(
            f"{error.what}, a cell of the study {folder}",
            remedy="give fewer --workers, if memory was short",
        ) from None
    finally:
        if own is not None:
            own.close()


def _run_cell(task: tuple[Experiment, int, int]) -> Best:
    return run_cell(*task)


def _work(experiment: Experiment) -> int:
    return experiment.individuals * experiment.evolution.generations


def _file(folder: Path, cell: Cell) -> Path:
    """Where a cell's result lies; that of another experiment or plugin's version lies elsewhere."""
    digest = hashlib.sha256(repr(cell.experiment).encode()).hexdigest()[:12]
    return folder / CELLS / f"{cell.index:06d}-{digest}.npy"
