"""The results of a study: one tidy table, and the cheapest cells that reach the target."""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gaitsim.runs.files.atomic import write_bytes, writing
from gaitsim.runs.files.drafts import sweep
from gaitsim.study.file import EXPERIMENT, STATISTICS, Cell, Scalar, Study
from gaitsim.study.running import Best, recorded

POPULATION = "evolution.population"
TABLE, REPORT = "results.csv", "report.md"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    return [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"
        for row in (columns, ["---"] * len(columns), *rows)
    ]


# With repeats that failed, whose score is −inf, some statistics are NaN; with huge ones, infinite.
@np.errstate(invalid="ignore", over="ignore")
def table(study: Study, results: Iterable[tuple[Cell, Best]]) -> str:
    """Return the results as CSV, a row for each cell and recorded generation.

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
        q25, median, q75 = np.quantile(best, [0.25, 0.5, 0.75], axis=0)
        std = best.std(axis=0, ddof=1) if len(best) > 1 else np.zeros(best.shape[1])
        columns = (best.mean(axis=0), std, median, q25, q75, best.min(axis=0), best.max(axis=0))
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


@np.errstate(over="ignore")
def first_reached(study: Study, results: Iterable[tuple[Cell, Best]]) -> list[Reached]:
    """Return the cheapest cell of each experiment that reaches the target."""
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


def summary(
    study: Study, results: Iterable[tuple[Cell, Best]]
) -> tuple[list[str], list[list[str]]]:
    """Return columns and rows of the cells that first reached the target, with published ones."""
    others = [axis for axis in study.axes if axis != POPULATION]
    columns = ["experiment", "population / generations", *others, "mean"]
    if study.published:
        columns.append("published")
    rows = []
    for found in first_reached(study, results):
        if found.population is None:
            blanks = [""] * len(others)
            row = [found.experiment, "never", *blanks, f"at most {number(found.mean)}"]
        else:
            row = [
                found.experiment,
                f"{found.population} / {found.generations}",
                *(str(found.point[axis]) for axis in others),
                number(found.mean),
            ]
        if study.published:
            cell = study.published.get(found.experiment)
            row.append(f"{cell.population} / {cell.generations}" if cell else "never")
        rows.append(row)
    return columns, rows


def number(value: float) -> str:
    """Return a score with three decimals and a true minus sign."""
    return f"{value:z.3f}".replace("-", "−")


def title(study: Study) -> str:
    """Return the heading of the summary."""
    return f"Cheapest population and generations that reach {study.target:g}"


def write_results(folder: Path, study: Study, results: Sequence[tuple[Cell, Best]]) -> None:
    """Write the table and, where the study has a target, the report.

    Raises:
        RunError: a file cannot be written.
    """
    sweep(folder)
    with writing(folder / REPORT):
        (folder / REPORT).unlink(missing_ok=True)
    write_bytes(folder / TABLE, table(study, results).encode(), follow=False)
    if study.target is None:
        return
    lines = [f"# {study.name}", "", study.description, "", f"## {title(study)}", ""]
    lines += [*markdown(*summary(study, results)), ""]
    lines += [f"Rule: {RULE}. Means of {study.repeats} repeats.", ""]
    write_bytes(folder / REPORT, "\n".join(lines).encode(), follow=False)
