"""What a study found: one tidy table, and what first reached the target."""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from gaitsim.study.file import EXPERIMENT, STATISTICS, Cell, Scalar, Study
from gaitsim.study.running import Best, recorded

POPULATION = "evolution.population"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a Markdown table."""
    return [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"
        for row in (columns, ["---"] * len(columns), *rows)
    ]


def table(study: Study, results: Iterable[tuple[Cell, Best]]) -> str:
    """The results as CSV, a row for each cell and recorded generation.

    Columns: the axes; generation; evaluations of one repeat until then; repeats; then
    mean, standard deviation, median, quartiles, least and greatest of the repeats' best
    scores so far.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([EXPERIMENT, *study.axes, "generation", "evaluations", "repeats", *STATISTICS])
    for cell, best in results:
        generations = recorded(cell.experiment, study.record_every)
        evaluations = generations * cell.experiment.individuals
        # Of repeats that failed, with −inf, what has no value is NaN.
        with np.errstate(invalid="ignore"):
            q25, median, q75 = np.quantile(best, [0.25, 0.5, 0.75], axis=0)
            sd = best.std(axis=0, ddof=1) if len(best) > 1 else np.zeros(best.shape[1])
        columns = (best.mean(axis=0), sd, median, q25, q75, best.min(axis=0), best.max(axis=0))
        for row in range(len(generations)):
            writer.writerow(
                [
                    *cell.point.values(),
                    int(generations[row]),
                    int(evaluations[row]),
                    len(best),
                    *(float(column[row]) for column in columns),
                ]
            )
    return text.getvalue()


@dataclass(frozen=True)
class Reached:
    """The cheapest cell of one experiment whose mean best score reaches the target.

    Attributes:
        experiment: its name on the axis.
        population, generations: the cell; None where none reaches it.
        mean: there, or the highest mean where none reaches it.
        point: the cell's values on the other axes, by name.
    """

    experiment: str
    population: int | None
    generations: int | None
    mean: float
    point: dict[str, Scalar]


RULE = (
    "reached: the mean over repeats of the best score so far is at least the target; of all "
    "such cells the one with the fewest evaluations (population × generations)"
)


def first_reached(study: Study, results: Iterable[tuple[Cell, Best]]) -> list[Reached]:
    """For each experiment the cheapest population and generations that reach the target."""
    target = np.inf if study.target is None else study.target
    cheapest: dict[str, tuple[int, Reached]] = {}
    highest: dict[str, float] = dict.fromkeys(study.experiments, -np.inf)
    for cell, best in results:
        name, population = str(cell.point[EXPERIMENT]), cell.experiment.evolution.population
        means = best.mean(axis=0)
        highest[name] = max(highest[name], float(means.max()))
        there = np.flatnonzero(means >= target)
        if len(there):
            generations = int(recorded(cell.experiment, study.record_every)[there[0]])
            rest = {axis: cell.point[axis] for axis in study.axes if axis != POPULATION}
            found = Reached(name, population, generations, float(means[there[0]]), rest)
            cost = cell.experiment.individuals * generations
            if name not in cheapest or cost < cheapest[name][0]:
                cheapest[name] = cost, found
    return [
        cheapest[name][1] if name in cheapest else Reached(name, None, None, highest[name], {})
        for name in study.experiments
    ]
