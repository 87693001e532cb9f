"""Run and store the fresh repeats that choose and test the cells of a study."""

from collections.abc import Callable, Sequence
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.evaluation import Executor
from gaitsim.evaluation.executors import cores
from gaitsim.evaluation.processes import OnWarning, ProcessExecutor
from gaitsim.study.confirmation import Reached, search
from gaitsim.study.file import EXPERIMENT, Cell, Study
from gaitsim.study.means import Means
from gaitsim.study.running import FRESH, Best, read_result, run_cells

OnSets = Callable[[int, int], None]
"""Called with the number of finished sets of fresh repeats, and the number of needed sets."""


def confirm(
    folder: Path,
    study: Study,
    results: Sequence[tuple[Cell, Best]],
    workers: int | None,
    *,
    on_sets: OnSets = lambda done, total: None,
    on_warning: OnWarning = lambda text: None,
    cluster: Executor | None = None,
) -> list[Reached]:
    """Find the cheapest cell of each experiment that reaches the target, using fresh repeats.

    Sets of repeats already in the folder are reused, so this function can be stopped at any time.

    Args:
        folder: folder of the study.
        study: the study.
        results: results of the sweep.
        workers: number of processes; None for one per core.
        on_sets: called whenever sets become needed or finished.
        on_warning: called with a message for the user when workers died.
        cluster: workers to use instead of processes; the caller closes it.

    Returns:
        One entry for each experiment, in order; [] without a target.
    """
    if study.target is None:
        return []
    searches = {
        name: search(
            study,
            study.target,
            [(cell, Means.of(best)) for cell, best in results if cell.point[EXPERIMENT] == name],
        )
        for name in study.experiments
    }
    found: dict[str, Reached] = {}
    fresh = study.fresh
    answers: dict[str, list[Means] | None] = dict.fromkeys(searches)
    done = total = 0
    own = ProcessExecutor(workers or cores(), on_warning) if cluster is None else None
    try:
        while answers:
            requested = {}
            for name, means in answers.items():
                try:
                    requested[name] = searches[name].send(means)  # type: ignore[arg-type]
                except StopIteration as stop:
                    found[name] = stop.value
            # The sets of all experiments run together, so that no worker waits for an experiment.
            needed = [cell for cells in requested.values() for cell in cells]
            missing = [one for one in needed if read_result(folder, fresh, one, FRESH) is None]
            done, total = done + len(needed) - len(missing), total + len(needed)
            on_sets(done, total)
            for _ in run_cells(folder, fresh, missing, workers, on_warning, cluster or own, FRESH):
                done += 1
                on_sets(done, total)
            answers = {
                name: [_means(folder, fresh, cell) for cell in cells]
                for name, cells in requested.items()
            }
    finally:
        if own is not None:
            own.close()
    return [found[name] for name in study.experiments]


def _means(folder: Path, fresh: Study, cell: Cell) -> Means:
    best = read_result(folder, fresh, cell, FRESH)
    if best is None:
        raise RunError(f"fresh repeats of cell {cell.index} of {folder} are missing or damaged")
    return Means.of(best)
