"""Verify a study: some of its cells, or the whole study, are run again in another folder."""

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from gaitsim.errors import RunError
from gaitsim.opening import is_folder, read_regular
from gaitsim.storage.files.folder import check_links
from gaitsim.study.confirmation import confirm
from gaitsim.study.file import STUDY, cells, read_study
from gaitsim.study.importance import importances
from gaitsim.study.results import LARGEST_REPORT, LARGEST_TABLE, REPORT, TABLE, write_results
from gaitsim.study.running import CELLS, FRESH, read_result, results, run_cells

SAMPLES = 10
"""Number of cells that are run again by default."""

LARGEST = {TABLE: LARGEST_TABLE, REPORT: LARGEST_REPORT}


@dataclass(frozen=True)
class StudyVerdict:
    """The result of verifying a study.

    Attributes:
        cells: number of cells.
        again: numbers of the cells that were run again.
        confirmed: whether the fresh repeats that confirm cells were run again, too.
        finished: whether the study was finished, so that its table and report were compared.
        differences: one message for each difference; () if all is identical.
    """

    cells: int
    again: tuple[int, ...]
    confirmed: bool
    finished: bool
    differences: tuple[str, ...]

    @property
    def identical(self) -> bool:
        """Whether everything that was compared is identical."""
        return not self.differences

    @property
    def complete(self) -> bool:
        """Whether the whole study was run again."""
        return self.finished and self.confirmed and len(self.again) == self.cells


def verify_study(
    folder: Path,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[], None] = lambda: None,
) -> StudyVerdict:
    """Run cells of a study again, and compare every bit of their results, table and report.

    Args:
        folder: folder of the study, which is not changed.
        everything: whether to run all cells and the fresh repeats again, rather than `SAMPLES`
            cells.
        workers: number of processes; None for one per core.
        begin: callback with the number of cells to run.
        advance: callback after each cell.
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
            for place in filter(lambda name: is_folder(folder / name), (CELLS, FRESH)):
                shutil.copytree(folder / place, there / place, symlinks=True)
        for cell in run_cells(there, study, chosen, workers):
            then, now = here[cell.index], read_result(there, study, cell)
            if then is None or now is None or not np.array_equal(then, now):
                found.append(f"the scores of cell {cell.index} ({_point(cell.point)}) differ")
            advance()
        if finished and len(present) == len(all_cells):
            scores, _ = results(there, study, all_cells)
            reached = confirm(there, study, scores, workers)
            write_results(there, study, scores, reached, importances(study, scores))
            for name in (TABLE, REPORT):
                if _content(folder, name) != _content(there, name):
                    found.append(f"{name} does not follow from the scores")
            found += _other_files(folder, there)
    again = tuple(sorted(cell.index for cell in chosen))
    confirmed = everything or study.target is None
    return StudyVerdict(len(all_cells), again, confirmed, finished, tuple(sorted(found)))


def _content(folder: Path, name: str) -> bytes | None:
    try:
        return read_regular(folder / name, LARGEST[name])
    except FileNotFoundError:
        return None


def _other_files(folder: Path, there: Path) -> list[str]:
    """Return differences between the fresh repeats of two folders."""
    if not is_folder(there / FRESH):
        return []
    found = []
    for file in sorted((there / FRESH).iterdir()):
        original = folder / FRESH / file.name
        if not original.exists():
            found.append(f"{FRESH}/{file.name} is missing")
        elif read_regular(original, file.stat().st_size + 1) != file.read_bytes():
            found.append(f"the fresh repeats in {FRESH}/{file.name} differ")
    return found


def _point(point: Mapping[str, object]) -> str:
    return ", ".join(f"{key} {value}" for key, value in point.items())
