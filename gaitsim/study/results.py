"""The results of a study: one tidy table, and the cheapest cells that reach the target."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from gaitsim.runs.files.atomic import write_bytes, writing
from gaitsim.runs.files.drafts import sweep
from gaitsim.study.confirmation import Reached
from gaitsim.study.file import EXPERIMENT, POPULATION, STATISTICS, Cell, Study
from gaitsim.study.running import Best, recorded_generations
from gaitsim.study.runtimes import target_text
from gaitsim.study.statistics import CONFIDENCE

TABLE, REPORT = "results.csv", "report.md"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    return [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"
        for row in (columns, ["---"] * len(columns), *rows)
    ]


# Failed repeats, with a score of −inf, make some statistics NaN; huge scores make them infinite.
@np.errstate(invalid="ignore", over="ignore")
def table(study: Study, results: Iterable[tuple[Cell, Best]]) -> str:
    """Return the results as CSV, with a row for each cell and recorded generation.

    The columns are the axes; generation; evaluations of one repeat so far; repeats; and mean,
    standard deviation, median, quartiles, minimum and maximum of the best scores so far.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([EXPERIMENT, *study.axes, "generation", "evaluations", "repeats", *STATISTICS])
    for cell, best in results:
        generations = recorded_generations(cell.experiment, study.record_every)
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


def rule(study: Study) -> str:
    """Return the rule that chose the cells of the summary, for reports."""
    error = 100 * (1 - CONFIDENCE) / len(study.experiments)
    sweep = "repeat" if study.repeats == 1 else f"{study.repeats:,} repeats"
    return (
        "the cell with the fewest evaluations (population × generations) whose mean best score, "
        "with its whole confidence interval, is at least the target in two sets of "
        f"{study.fresh.repeats:,} fresh repeats. The {sweep} of the sweep can only propose cells, "
        "because the cheapest of many noisy means is usually there by chance. The first set "
        "chooses a cell, and the second set tests it. Mean and interval are those of the second "
        "set, which has no part in the choice. The first test of an experiment has a level of "
        f"{100 - error / 2:.4g} %, and each further test half the error of the previous one, so "
        f"all intervals hold together with {100 * CONFIDENCE:g} % confidence (Bonferroni). "
        "'never' means that no cell passes; the cell in brackets has the highest mean of the "
        "sweep, and was also tested with fresh repeats"
    )


def summary(study: Study, found: Iterable[Reached]) -> tuple[list[str], list[list[str]]]:
    """Return columns and rows of the cells that reach the target, with published cells."""
    others = [axis for axis in study.axes if axis != POPULATION]
    columns = ["experiment", "cheapest", *others, "mean, interval"]
    if study.published:
        columns.append("published")
    rows = []
    for one in found:
        where = f"{one.population} / {one.generations}"
        row = [
            one.experiment,
            where if one.reached else f"never ({where})",
            *(str(one.point[axis]) for axis in others),
            f"{number(one.mean)} ({number(one.low)} to {number(one.high)})",
        ]
        if study.published:
            cell = study.published.get(one.experiment)
            row.append(f"{cell.population} / {cell.generations}" if cell else "never")
        rows.append(row)
    return columns, rows


def number(value: float) -> str:
    """Return a score with three decimals and a true minus sign."""
    return f"{value:z.3f}".replace("-", "−")


def title(study: Study) -> str:
    """Return the heading of the summary of a study with a target."""
    assert study.target is not None, "only a study with a target has a summary"
    return f"Cheapest population and generations that reach {target_text(study.target)}"


def write_results(
    folder: Path,
    study: Study,
    results: Sequence[tuple[Cell, Best]],
    reached: Sequence[Reached] = (),
) -> None:
    """Write the table and, if the study has a target, the report.

    Args:
        folder: folder of the study.
        study: the study.
        results: results of the sweep.
        reached: cheapest cell of each experiment that reaches the target.
    """
    sweep(folder)
    with writing(folder / REPORT):
        (folder / REPORT).unlink(missing_ok=True)
    write_bytes(folder / TABLE, table(study, results).encode(), follow=False)
    if study.target is None:
        return
    lines = [f"# {study.name}", "", study.description, "", f"## {title(study)}", ""]
    lines += [*markdown(*summary(study, reached)), ""]
    lines += [f"Rule: {rule(study)}.", ""]
    write_bytes(folder / REPORT, "\n".join(lines).encode(), follow=False)
