"""Find the cheapest cells that reach the target, with a statistical guarantee.

Among many noisy means, the cheapest one above a target is usually there by chance, and the true
mean of its cell misses the target. The sweep therefore only proposes cells. Two sets of fresh
repeats, with independent random numbers, decide: the first set chooses candidates in order of cost,
and the second set tests them one by one. The second set has no part in the choice. A cell is
reported if its test succeeds, so the means of reported cells are slightly too high on average, but
the error of each test is bounded. The k-th test of an experiment has the error 0.05 / (2ᵏ E) in a
study of E experiments. By Bonferroni's inequality, the probability of any error in a study is at
most 0.05, for any number of tests.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gaitsim.plugin import RunError
from gaitsim.plugin.runs import Executor, OnWarning, ProcessExecutor, Purpose, cores, stream
from gaitsim_studies.file import EXPERIMENT, POPULATION, Cell, Scalar, Study
from gaitsim_studies.running import FRESH, Best, read_result, recorded_generations, run_cells
from gaitsim_studies.statistics import CONFIDENCE, Means

Sweep = Sequence[tuple[Cell, Means]]
Search = Generator[list[Cell], list[Means], "ReachedTarget"]


@dataclass(frozen=True)
class ReachedTarget:
    """The cheapest cell of one experiment that reaches the target, or else the highest cell.

    Attributes:
        experiment: name of the experiment on its axis.
        reached: whether the target is reached.
        population, generations: population and generations of the cell.
        point: values of the cell on the other axes, by name.
        mean: mean of fresh repeats that had no part in the choice of the cell.
        low, high: confidence interval of the mean.
        level: confidence level of the interval, chosen so that all intervals of a study hold
            together with 95 % confidence.
        repeats: number of fresh repeats; 0 if no mean of the sweep is finite, so that none was
            tested.
    """

    experiment: str
    reached: bool
    population: int
    generations: int
    point: dict[str, Scalar]
    mean: float
    low: float
    high: float
    level: float
    repeats: int


@dataclass(frozen=True)
class _Candidate:
    """A cell at one recorded generation that may reach the target, according to the sweep.

    Attributes:
        cell: the cell.
        place: index of the generation among the recorded generations.
        cost: number of evaluations up to this generation.
        clear: whether the whole interval of the sweep's mean is above the target.
    """

    cell: Cell
    place: int
    cost: int
    clear: bool

    def low(self, sets: dict[int, Means], level: float) -> float | None:
        """Return the lower end of the interval of the mean in fresh sets; None if unknown."""
        found = sets.get(self.cell.index)
        if found is None or self.place >= len(found.mean):
            return None
        return float(found.interval(level)[0][self.place])


def search(study: Study, target: float, sweep: Sweep) -> Search:
    """Find the cheapest cell of one experiment that reaches the target, using fresh repeats.

    Args:
        study: the study.
        target: mean best score to reach.
        sweep: cells of one experiment, with the means of their repeats.

    Yields:
        Cells that need fresh repeats; the caller sends their means back.

    Returns:
        The cheapest cell whose test succeeds, or else the cell with the highest mean.
    """
    share = (1 - CONFIDENCE) / len(study.experiments)
    candidates = _candidates(study, sweep, target)
    first: dict[int, Means] = {}
    second: dict[int, Means] = {}
    level = 1 - share / 2
    while candidates:
        yield from _screen(study, candidates, first, target, level)
        chosen = _cheapest(candidates, first, target, level)
        if chosen is None:
            break
        cell, last = chosen.cell, len(first[chosen.cell.index].mean) - 1
        if chosen.low(second, level) is None:
            (second[cell.index],) = yield [fresh_cell(study, cell, last, Purpose.CONFIRMATION)]
        if (low := chosen.low(second, level)) is not None and low >= target:
            return _reached(study, chosen.cell, chosen.place, second[cell.index], level, True)
        candidates.remove(chosen)
        share /= 2
        level = 1 - share / 2
    # No candidate passed. The last test is of the highest mean, which may have missed the target
    # only because the sweep has few repeats.
    cell, place, means = _highest(sweep)
    if np.isneginf(means.mean[place]):
        return _reached(study, cell, place, replace(means, repeats=0), level, False)
    held = second.get(cell.index)
    if held is None or place >= len(held.mean):
        (held,) = yield [fresh_cell(study, cell, place, Purpose.CONFIRMATION)]
    passes = bool(held.interval(level)[0][place] >= target)
    return _reached(study, cell, place, held, level, passes)


def fresh_cell(study: Study, cell: Cell, place: int, purpose: Purpose) -> Cell:
    """Return a cell up to a recorded generation, with an independent seed for a purpose."""
    experiment = cell.experiment
    generations = int(recorded_generations(experiment, study.record_every)[place])
    seed = int(stream(experiment.seed, 0, purpose).integers(2**63))
    evolution = experiment.evolution.model_copy(update={"generations": generations})
    return replace(cell, experiment=replace(experiment, seed=seed, evolution=evolution))


def _candidates(study: Study, sweep: Sweep, target: float) -> list[_Candidate]:
    """Return the cells of the sweep whose interval reaches the target, the cheapest first."""
    found = []
    for cell, means in sweep:
        low, high = means.interval(CONFIDENCE)
        generations = recorded_generations(cell.experiment, study.record_every)
        for place in np.flatnonzero(high >= target).tolist():
            cost = int(generations[place]) * cell.experiment.individuals
            found.append(_Candidate(cell, place, cost, bool(low[place] >= target)))
    return sorted(found, key=lambda one: (one.cost, one.cell.index))


def _screen(
    study: Study,
    candidates: Sequence[_Candidate],
    first: dict[int, Means],
    target: float,
    level: float,
) -> Generator[list[Cell], list[Means], None]:
    """Request first sets until they show which candidate is the cheapest to reach the target.

    Candidates that cost more than a candidate that clearly reaches the target are not repeated.
    """
    while True:
        needed: dict[int, _Candidate] = {}
        for one in candidates:
            low = one.low(first, level)
            if low is None:
                held = needed.get(one.cell.index)
                if held is None or one.place > held.place:
                    needed[one.cell.index] = one
            if low >= target if low is not None else one.clear:
                break
        if not needed:
            return
        requested = [
            fresh_cell(study, one.cell, one.place, Purpose.SCREENING) for one in needed.values()
        ]
        means = yield requested
        first.update(zip(needed, means, strict=True))


def _cheapest(
    candidates: Sequence[_Candidate], first: dict[int, Means], target: float, level: float
) -> _Candidate | None:
    for one in candidates:
        low = one.low(first, level)
        if low is not None and low >= target:
            return one
    return None


def _highest(sweep: Sweep) -> tuple[Cell, int, Means]:
    """Return the cell with the sweep's highest mean, the index of its generation, and its means."""
    cell, means = max(sweep, key=lambda one: float(one[1].mean.max()))
    return cell, int(means.mean.argmax()), means


def _reached(
    study: Study, cell: Cell, place: int, means: Means, level: float, reached: bool
) -> ReachedTarget:
    low, high = means.interval(level)
    return ReachedTarget(
        experiment=str(cell.point[EXPERIMENT]),
        reached=reached,
        population=cell.experiment.evolution.population,
        generations=int(recorded_generations(cell.experiment, study.record_every)[place]),
        point={axis: cell.point[axis] for axis in study.axes if axis != POPULATION},
        mean=float(means.mean[place]),
        low=float(low[place]),
        high=float(high[place]),
        level=level,
        repeats=means.repeats,
    )


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
) -> list[ReachedTarget]:
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
    found: dict[str, ReachedTarget] = {}
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
