"""Find the cheapest cells that reach the target, so that the claim holds.

The cheapest of many noisy means above a target is one that was lucky: most of the cells that a
sweep finds there miss it. So the sweep only proposes cells. Two sets of fresh repeats, of random
numbers of their own, decide: the first one chooses the candidates, in order of cost; the second
one tests them, one after another. Nothing in the second set had a part in the choice, so its mean
is unbiased. The k-th test of an experiment has the error 0.05 / (2ᵏ E) in a study of E
experiments: by Bonferroni's inequality all tests of a study together err with a probability of
at most 0.05, however many there are and whenever they stop.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.study.file import EXPERIMENT, POPULATION, Cell, Scalar, Study
from gaitsim.study.means import Means
from gaitsim.study.running import recorded
from gaitsim.study.statistics import CONFIDENCE

Sweep = Sequence[tuple[Cell, Means]]
Search = Generator[list[Cell], list[Means], "Reached"]


@dataclass(frozen=True)
class Reached:
    """The cheapest cell of one experiment that reaches the target, or the highest where none does.

    Attributes:
        experiment: its name on the axis.
        reached: whether the target is reached.
        population, generations: the cell.
        point: its values on the other axes, by name.
        mean: of fresh repeats that had no part in the choice of the cell.
        low, high: confidence interval of the mean.
        level: the confidence of the interval, with which all those of a study hold together
            with 95 %.
        repeats: number of fresh repeats; 0 where the mean is the sweep's, as nothing is finite.
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
    """A cell at one recorded generation, which by the sweep may reach the target.

    Attributes:
        cell: the cell.
        place: of the generation among the recorded ones.
        cost: evaluations until then.
        clear: whether the whole interval of its mean in the sweep is above the target.
    """

    cell: Cell
    place: int
    cost: int
    clear: bool

    def low(self, sets: dict[int, Means], level: float) -> float | None:
        """Return the lower end of the interval of its mean in fresh sets; None without one."""
        found = sets.get(self.cell.index)
        if found is None or self.place >= len(found.mean):
            return None
        return float(found.interval(level)[0][self.place])


def search(study: Study, target: float, sweep: Sweep) -> Search:
    """Find the cheapest cell of one experiment that reaches the target, by fresh sets.

    Args:
        study: the study.
        target: mean best score to reach.
        sweep: the cells of one experiment, with the means of their repeats.

    Yields:
        Cells to repeat afresh; their means are sent back.

    Returns:
        The cheapest cell whose test succeeds; else the one with the highest mean.
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
            (second[cell.index],) = yield [afresh(study, cell, last, Purpose.CONFIRMATION)]
        if (low := chosen.low(second, level)) is not None and low >= target:
            return _reached(study, chosen.cell, chosen.place, second[cell.index], level, True)
        candidates.remove(chosen)
        share /= 2
        level = 1 - share / 2
    # The last test is of the highest mean, which few repeats may have put below the target.
    cell, place, means = _highest(sweep)
    if np.isneginf(means.mean[place]):
        return _reached(study, cell, place, replace(means, repeats=0), level, False)
    held = second.get(cell.index)
    if held is None or place >= len(held.mean):
        (held,) = yield [afresh(study, cell, place, Purpose.CONFIRMATION)]
    passes = bool(held.interval(level)[0][place] >= target)
    return _reached(study, cell, place, held, level, passes)


def afresh(study: Study, cell: Cell, place: int, purpose: Purpose) -> Cell:
    """Return a cell up to a recorded generation, with random numbers for another purpose."""
    experiment = cell.experiment
    generations = int(recorded(experiment, study.record_every)[place])
    seed = int(stream(experiment.seed, 0, purpose).integers(2**63))
    evolution = experiment.evolution.model_copy(update={"generations": generations})
    return replace(cell, experiment=replace(experiment, seed=seed, evolution=evolution))


def _candidates(study: Study, sweep: Sweep, target: float) -> list[_Candidate]:
    """Return what the sweep proposes, the cheapest first: means that miss by noise at most."""
    found = []
    for cell, means in sweep:
        low, high = means.interval(CONFIDENCE)
        generations = recorded(cell.experiment, study.record_every)
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
    """Add to the first sets what decides which candidate is the cheapest that reaches the target.

    Candidates that cost more than one that surely reaches it are not repeated.
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
        asked = [afresh(study, one.cell, one.place, Purpose.SCREENING) for one in needed.values()]
        means = yield asked
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
    """Return the cell, and the place of its generation, with the sweep's highest mean."""
    cell, means = max(sweep, key=lambda one: float(one[1].mean.max()))
    return cell, int(means.mean.argmax()), means


def _reached(
    study: Study, cell: Cell, place: int, means: Means, level: float, reached: bool
) -> Reached:
    low, high = means.interval(level)
    return Reached(
        experiment=str(cell.point[EXPERIMENT]),
        reached=reached,
        population=cell.experiment.evolution.population,
        generations=int(recorded(cell.experiment, study.record_every)[place]),
        point={axis: cell.point[axis] for axis in study.axes if axis != POPULATION},
        mean=float(means.mean[place]),
        low=float(low[place]),
        high=float(high[place]),
        level=level,
        repeats=means.repeats,
    )
