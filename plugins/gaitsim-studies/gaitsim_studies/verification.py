"""Verify a study: some of its cells, or the whole study, are run again in another folder."""

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from gaitsim.plugin import RunError, is_folder, read_regular
from gaitsim.plugin.runs import Account, FilesVerdict, check_links
from gaitsim_studies.confirmation import confirm
from gaitsim_studies.file import STUDY, Cell, Study, cells, read_study
from gaitsim_studies.results import LARGEST_REPORT, LARGEST_TABLE, REPORT, TABLE, write_results
from gaitsim_studies.running import (
    CELLS,
    FRESH,
    Best,
    read_result,
    recorded_generations,
    results,
    run_cells,
    write_result,
)

SAMPLES = 10
"""Number of cells that are run again by default."""

LARGEST = {TABLE: LARGEST_TABLE, REPORT: LARGEST_REPORT}


def verify_study(
    folder: Path,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[int], None] = lambda steps: None,
) -> FilesVerdict:
    """Run cells of a study again, and compare every bit of their results, table and report.

    Args:
        folder: folder of the study, which is not changed.
        everything: whether to run all cells and the fresh repeats again, rather than `SAMPLES`
            cells.
        workers: number of processes; None for one per core.
        begin: callback with the number of cells to run.
        advance: callback with the number of cells run since the last call.
    """
    check_links(folder)
    study, _ = read_study(str(folder / STUDY))
    all_cells = cells(study, folder, str(folder / STUDY))
    here = {cell.index: read_result(folder, study, cell) for cell in all_cells}
    present = [cell for cell in all_cells if here[cell.index] is not None]
    if not present:
        raise RunError(
            f"the study {folder} has no cell that the installed versions have computed",
            remedy="run it with the versions that evolved it",
        )
    places = np.linspace(0, len(present) - 1, min(SAMPLES, len(present))).round().astype(int)
    chosen = present if everything else [present[place] for place in {*places.tolist()}]
    finished = (folder / TABLE).exists()
    found = []
    if finished:
        found = [
            f"cell {cell.index} is missing or damaged"
            for cell in all_cells
            if here[cell.index] is None
        ]
    begin(len(chosen))
    with TemporaryDirectory() as temporary:
        there = Path(temporary, "study")
        there.mkdir()
        if not everything:  # the other results are taken as they are
            _copy_results(folder, there, study, all_cells, here)
        for cell in run_cells(there, study, chosen, workers):
            then, now = here[cell.index], read_result(there, study, cell)
            if then is None or now is None or not np.array_equal(then, now):
                found.append(f"the scores of cell {cell.index} ({_point(cell.point)}) differ")
            advance(1)
        if finished and len(present) == len(all_cells):
            scores, _ = results(there, study, all_cells)
            reached = confirm(there, study, scores, workers)
            write_results(there, study, scores, reached)
            for name, largest in LARGEST.items():
                if _content(folder / name, largest) != _content(there / name, largest):
                    found.append(f"{name} does not follow from the scores")
            found += _other_files(folder, there)
    notes = []
    if not everything and study.target is not None:
        notes.append("the fresh repeats that confirm cells were not run again; --all does so")
    if not finished:
        notes.append("the study is not finished: it has no table and no report to compare")
    return FilesVerdict(
        "study",
        "cells run",
        len(all_cells),
        tuple(sorted(cell.index for cell in chosen)),
        len(chosen) == len(all_cells) and not notes,
        tuple(sorted(found)),
        _accounts(folder, study, len(chosen), len(all_cells), everything),
        tuple(notes),
    )


def _accounts(
    folder: Path, study: Study, again: int, total: int, everything: bool
) -> tuple[Account, ...]:
    """Return the comparisons of each file of a study."""
    rest, experiments = total - again, len(study.experiments)
    options = "compared with the keys of the results"
    texts = "" if (folder / REPORT).exists() else "name, description, published cells"
    rows = [
        Account(STUDY, options, texts),
        Account(
            "1.toml" if experiments == 1 else f"1.toml to {experiments}.toml",
            options,
            "options that the study sets",
        ),
        Account(
            f"{CELLS}/",
            f"{again:,} of {total:,} run again",
            f"the scores of {rest:,} cells" if rest else "",
        ),
    ]
    if is_folder(folder / FRESH):
        done = "run again" if everything else f"compared with {REPORT}"
        rows.append(Account(f"{FRESH}/", done, "" if everything else "its scores"))
    rows += [
        Account(name, f"computed again from {CELLS}/")
        for name in (TABLE, REPORT)
        if (folder / name).exists()
    ]
    return tuple(rows)


def _copy_results(
    folder: Path, there: Path, study: Study, all_cells: list[Cell], here: Mapping[int, Best | None]
) -> None:
    """Copy the results of cells and of fresh repeats; a folder may hold pipes and huge files."""
    (there / CELLS).mkdir()
    for cell in all_cells:
        if (best := here[cell.index]) is not None:
            write_result(there, study, cell, best)
    if not is_folder(folder / FRESH):
        return
    (there / FRESH).mkdir()
    recorded = (recorded_generations(one.experiment, study.record_every) for one in all_cells)
    largest = 8 * study.fresh.repeats * max(map(len, recorded)) + 1000
    for file in islice((folder / FRESH).iterdir(), 2 * len(all_cells) + 1000):
        if re.fullmatch(r"\d{6,9}-[0-9a-f]{16}\.npy", file.name):
            with suppress(OSError):
                (there / FRESH / file.name).write_bytes(read_regular(file, largest))


def _content(file: Path, largest: int) -> bytes | None:
    """Return the content of a file; None if it is missing, too large or not a regular file."""
    try:
        return read_regular(file, largest)
    except OSError:
        return None


def _other_files(folder: Path, there: Path) -> list[str]:
    """Return differences between the fresh repeats of two folders."""
    if not is_folder(there / FRESH):
        return []
    found = []
    for file in sorted((there / FRESH).iterdir()):
        name, size = f"{FRESH}/{file.name}", file.stat().st_size
        then = _content(folder / name, size)
        if then is None:
            found.append(f"{name} is missing or damaged")
        elif then != file.read_bytes():
            found.append(f"the fresh repeats in {name} differ")
    return found


def _point(point: Mapping[str, object]) -> str:
    return ", ".join(f"{key} {value}" for key, value in point.items())
