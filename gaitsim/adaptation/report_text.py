"""A report of adaptations as text: a CSV table of all trials and a summary in Markdown."""

import statistics
from collections.abc import Callable, Sequence

from gaitsim.adaptation.report import Case, Report
from gaitsim.runs.files.tables import line

TRIALS, SUMMARY = "trials.csv", "report.md"
_COLUMNS = ("damage", "way", "trial", "member", "expected", "deviation", "measured", "kept")


def trials_table(report: Report) -> str:
    """Return a CSV table with a row for each trial, followed by the random gaits of its case."""
    text = line(_COLUMNS)
    for case in report.cases:
        for trial in case.trials:
            text += line(
                [
                    case.name,
                    "adaptation",
                    trial.number,
                    trial.member,
                    trial.expected,
                    trial.deviation,
                    trial.measured,
                    report.kept(trial.measured),
                ]
            )
        for number, measured in enumerate(case.random, 1):
            text += line([case.name, "random", number, "", "", "", measured, report.kept(measured)])
    return text


def summary(report: Report, source: str, figures: Sequence[str] = ()) -> str:
    """Return a summary of the report in Markdown.

    Args:
        report: the report, with all its cases.
        source: name of the atlas.
        figures: names of image files in the same folder, which are shown below the table.
    """
    where = "in rigid-body physics" if report.place == "physics" else "in simulation"
    measured = len(report.intact)
    unit = f" {report.unit}".rstrip()
    lines = [
        f"# {source}: adaptation to damage",
        "",
        f"Trials {where}. Best on the intact body: {report.best:.3g}{unit}"
        + (f", of the {measured} most promising gaits." if measured > 1 else "."),
        "The last three columns are shares of this value. Kept: the best gait found by adaptation. "
        "Champion: the map's best gait, without adaptation. Random: the best of as many "
        "random gaits of the map as there were trials.",
        "",
        "| damage | trials | kept | champion | random |",
        "| --- | --- | --- | --- | --- |",
    ]
    lines += [_row(report, case.name, [case]) for case in report.cases]
    for count in sorted({len(case.damage) for case in report.cases}):
        cases = [case for case in report.cases if len(case.damage) == count]
        words = "one leg" if count == 1 else f"{count} legs"
        lines.append(_row(report, f"**{words}, median of {len(cases)}**", cases))
    return "\n".join([*lines, "", *(f"![]({figure})" for figure in figures)]).rstrip() + "\n"


def _row(report: Report, name: str, cases: Sequence[Case]) -> str:
    def median(value: Callable[[Case], float]) -> float:
        return statistics.median(map(value, cases))

    shares = (
        median(lambda case: report.kept(case.best.measured)),
        median(lambda case: report.kept(case.champion)),
        median(lambda case: report.kept(max(case.random))),
    )
    cells = [name, f"{median(lambda case: len(case.trials)):g}", *(f"{one:.0%}" for one in shares)]
    return f"| {' | '.join(cells)} |"
