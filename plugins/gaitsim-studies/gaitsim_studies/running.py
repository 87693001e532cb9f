"""Run a study cell by cell, and a comparison part by part; both resume with the missing results.

Results are stored under keys: hashes of everything that a result depends on.
"""

import hashlib
import io
import json
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, read_regular
from gaitsim.plugin.runs import (
    Evaluator,
    Executor,
    Experiment,
    OnWarning,
    ProcessExecutor,
    WorkerLostError,
    cores,
    create_subfolder,
    evolve_repeats,
    sweep,
    write_bytes,
)
from gaitsim_studies.file import Cell, Study

_OWN = "gaitsim"
# The dependencies of gaitsim that compute results. `gaitsim.storage.compatibility.versions` lists
# only loaded engines, but a key must not depend on the modules that this process has loaded.
_NUMERICAL = (_OWN, "mujoco-core", "numba", "numpy", "pymunk", "scipy")


def result_key(experiment: Experiment, repeats: int, generations: Sequence[int]) -> str:
    """Return a key of 16 hexadecimal digits for the scores of repeats.

    The key is a hash of the whole experiment, the versions of the packages that compute it, the
    number of repeats and the recorded generations. It does not change if the code of a plugin
    changes while its package keeps its version.
    """
    plugins = {kind: entry.source for kind, entry in experiment.entries.items()}
    packages = {entry.package for entry in experiment.entries.values()}
    used = {*_NUMERICAL, *(name for package in packages for name in _requirements(package))}
    versions = {name: _version(name) for name in used} | plugins
    parts = [experiment.to_dict(), versions, repeats, [*generations]]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


@cache
def _requirements(package: str) -> tuple[str, ...]:
    """Return the packages that a package other than gaitsim requires."""
    if package == _OWN:
        return ()  # `_NUMERICAL` lists those of its requirements that compute results
    try:
        given = requires(package) or ()
    except PackageNotFoundError:
        return ()
    # "jax>=0.4; python_version > '3.10'" requires jax.
    return tuple(re.split(r"[^\w.-]", text.strip(), maxsplit=1)[0] for text in given)


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # an extra requires it, and it is not installed
        return ""


CELLS = "cells"
FRESH = "confirmation"  # the folder of fresh repeats

Best = NDArray[np.float64]
"""Best score so far, (repeats, recorded generations)."""


def recorded_generations(experiment: Experiment, every: int) -> NDArray[np.int64]:
    """Return the recorded generations: every `every` generations, and the last."""
    last = experiment.evolution.generations
    numbers = np.arange(every, last + 1, every)
    return numbers if len(numbers) and numbers[-1] == last else np.append(numbers, last)


def repeat_experiment(
    experiment: Experiment,
    repeats: int,
    every: int = 1,
    *,
    workers: int | None = 1,
    on_generation: Callable[[], None] = lambda: None,
    on_warning: OnWarning = lambda text: None,
    cluster: Executor | None = None,
) -> Best:
    """Return the best scores of repeats of an experiment, at the recorded generations.

    Args:
        experiment: experiment to repeat.
        repeats: number of repeats.
        every: interval between recorded generations.
        workers: number of workers; None for one per core.
        on_generation: called after each generation.
        on_warning: called with a message for the user when workers died or are idle.
        cluster: workers to use instead of `workers`; the caller closes it.
    """
    kept = set(recorded_generations(experiment, every).tolist())
    best = []
    with Evaluator(experiment, workers, on_warning, cluster) as evaluator:
        evaluator.prepare(repeats * experiment.individuals)
        for number, scores in enumerate(evolve_repeats(experiment, evaluator.evaluate, repeats), 1):
            if number in kept:
                best.append(scores)
            on_generation()
    return np.stack(best, axis=1)


MOST_PARTS = 100_000  # files read in a folder of repeats
_PART = re.compile(r"(\d{1,6})-(\d{1,6})-(\d{1,6})-([0-9a-f]{16})\.npy")


def read_repeats(folder: Path, place: int, experiment: Experiment, repeats: int) -> Best:
    """Return the finished repeats of an experiment of a comparison; NaN for missing repeats.

    Args:
        folder: folder of the repeats.
        place: number of the experiment.
        experiment: experiment to repeat.
        repeats: number of repeats.
    """
    generations = recorded_generations(experiment, 1)
    best = np.full((repeats, len(generations)), np.nan)
    key = result_key(experiment, repeats, generations.tolist())
    for entry in islice(os.scandir(folder), MOST_PARTS):
        match = _PART.fullmatch(entry.name)
        if match is None or (int(match[1]), match[4]) != (place, key):
            continue
        first, end = int(match[2]), int(match[3])
        if first < end <= repeats:
            found = _read_best(Path(entry.path), (end - first, len(generations)))
            if found is not None:
                best[first:end] = found
    return best


def complete_repeats(
    folder: Path,
    place: int,
    experiment: Experiment,
    best: Best,
    *,
    workers: int | None = None,
    on_generation: Callable[[int], object] = lambda repeats: None,
    on_warning: OnWarning = lambda text: None,
    cluster: Executor | None = None,
) -> None:
    """Evolve the missing repeats of an experiment, and write each part that is finished.

    Repeats that share random streams are one part; others are evolved in parts that occupy all
    workers.

    Args:
        folder: folder of the repeats.
        place: number of the experiment.
        experiment: experiment to repeat.
        best: result of `read_repeats` with missing repeats, which is completed in place.
        workers: number of workers; None for the body's default.
        on_generation: called after each generation with the number of repeats in it.
        on_warning: called with a message for the user when workers died or are idle.
        cluster: workers to use instead of `workers`; the caller closes it.
    """
    repeats = len(best)
    missing = np.flatnonzero(np.isnan(best[:, 0])).tolist()
    key = result_key(experiment, repeats, recorded_generations(experiment, 1).tolist())
    with Evaluator(experiment, workers, on_warning, cluster) as evaluator:
        size = -(-PER_WORKER * evaluator.workers // experiment.individuals)
        parts = _parts(missing, size)
        if experiment.search.several:
            parts = [range(repeats)]
        evaluator.prepare(max(map(len, parts)) * experiment.individuals)
        for part in parts:
            each = evolve_repeats(experiment, evaluator.evaluate, repeats, only=part)
            for number, scores in enumerate(each):
                best[part.start : part.stop, number] = scores
                on_generation(len(part))
            name = f"{place}-{part.start}-{part.stop}-{key}.npy"
            _write_best(folder / name, best[part.start : part.stop])


PER_WORKER = 64  # individuals in a generation of a part; more are not faster


def _parts(missing: Sequence[int], size: int) -> list[range]:
    """Return ascending numbers as ranges of at most `size` consecutive numbers."""
    parts: list[range] = []
    for number in missing:
        last = parts[-1] if parts else range(0)
        if parts and number == last.stop and len(last) < size:
            parts[-1] = range(last.start, number + 1)
        else:
            parts.append(range(number, number + 1))
    return parts


def read_result(folder: Path, study: Study, cell: Cell, place: str = CELLS) -> Best | None:
    """Return the result of a cell; None if it is missing or damaged."""
    shape = (study.repeats, len(recorded_generations(cell.experiment, study.record_every)))
    return _read_best(_file(folder / place, study, cell), shape)


def write_result(folder: Path, study: Study, cell: Cell, best: Best, place: str = CELLS) -> None:
    """Write the result of a cell to the subfolder `place`, which exists."""
    _write_best(_file(folder / place, study, cell), best)


def _read_best(path: Path, shape: tuple[int, int]) -> Best | None:
    """Return the best scores in a file; None if it is missing or damaged."""
    start = io.BytesIO()
    described = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(start, described)
    head, size = start.getvalue(), 8 * math.prod(shape)
    try:
        data = read_regular(path, len(head) + size)
    except OSError:
        return None
    # Every byte of the header is known, so a damaged file is never parsed.
    if len(data) != len(head) + size or not data.startswith(head):
        return None
    best = np.frombuffer(data, np.float64, offset=len(head)).reshape(shape)
    return best if (best < np.inf).all() else None


def _write_best(path: Path, best: Best) -> None:
    file = io.BytesIO()
    np.save(file, best, allow_pickle=False)
    write_bytes(path, file.getvalue(), follow=False)


def results(
    folder: Path, study: Study, cells: Sequence[Cell]
) -> tuple[list[tuple[Cell, Best]], list[Cell]]:
    """Return the finished cells with their results, and the missing cells."""
    found = [(cell, read_result(folder, study, cell)) for cell in cells]
    return (
        [(cell, best) for cell, best in found if best is not None],
        [cell for cell, best in found if best is None],
    )


def run_cells(
    folder: Path,
    study: Study,
    cells: Sequence[Cell],
    workers: int | None,
    on_warning: OnWarning = lambda text: None,
    cluster: Executor | None = None,
    place: str = CELLS,
) -> Iterator[Cell]:
    """Run cells in worker processes; write and yield each finished cell.

    Closing the iterator stops the workers. The next call starts unfinished cells from scratch.

    Args:
        folder: folder of the study.
        study: study with the number of repeats and the recorded generations.
        cells: cells to run.
        workers: number of processes; None for one per core.
        on_warning: called with a message for the user when workers died.
        cluster: workers to use instead of processes; the caller closes it.
        place: subfolder for the results.
    """
    sweep(create_subfolder(folder, place))
    # The longest cells run first, so that none of them occupies a single core at the end.
    ordered = sorted(cells, key=lambda cell: -_work(cell.experiment))
    tasks = [(cell.experiment, study.repeats, study.record_every) for cell in ordered]
    count = min(workers or cores(), max(1, len(cells)))
    executor = ProcessExecutor(count, on_warning) if cluster is None else cluster
    try:
        executor.check(cell.experiment for cell in ordered)
        for number, best in executor.each(_run_cell, tasks):
            cell = ordered[number]
            write_result(folder, study, cell, best, place)
            yield cell
    except WorkerLostError as error:
        raise GaitsimError(
            f"{error.what}, a cell of the study {folder}",
            remedy="try fewer --workers, in case memory ran out",
        ) from None
    finally:
        if executor is not cluster:
            executor.close()


def _run_cell(task: tuple[Experiment, int, int]) -> Best:
    return repeat_experiment(*task)


def _work(experiment: Experiment) -> int:
    return experiment.individuals * experiment.evolution.generations


def _file(folder: Path, study: Study, cell: Cell) -> Path:
    """Return the file of a cell's result, named after the key of the result."""
    generations = recorded_generations(cell.experiment, study.record_every).tolist()
    key = result_key(cell.experiment, study.repeats, generations)
    return folder / f"{cell.index:06d}-{key}.npy"
