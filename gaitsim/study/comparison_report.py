"""The report of a comparison: tables, a paragraph of methods, CSV and JSON."""

import csv
import io
import math
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.runs.files.atomic import write_bytes
from gaitsim.study.comparison import Findings
from gaitsim.study.results import markdown, number
from gaitsim.study.statistics import CONFIDENCE, RESAMPLES

REPORT, TABLE, CURVES = "report.md", "results.csv", "ecdf.csv"
MOST_ROWS = 200  # of one repeat in a table


def methods(findings: Findings) -> str:
    """Return a paragraph for the methods section of a paper."""
    pairs, few = len(findings.pairs), next(iter(findings.reached.values()))
    targets = ", ".join(_short(one.target, 6) for one in few)
    return (
        f"Each of the {len(findings.samples)} experiments was repeated {findings.repeats} times "
        f"with {findings.evaluations:,} evaluations from independent random populations (gaitsim "
        f"{version('gaitsim')}); a score counts when its generation is finished. The outcome of a "
        f"repeat is its best score. We report medians with {CONFIDENCE:.0%} percentile bootstrap "
        f"confidence intervals ({RESAMPLES:,} resamples of the repeats) and quartiles. Pairs were "
        f"compared by two-sided Mann–Whitney U tests, corrected for {pairs} "
        f"comparison{'s' * (pairs != 1)} by Holm's procedure, with the Vargha–Delaney A12 as "
        "effect size (Arcuri and Briand 2011). The ECDF of runtimes is the share of pairs of a "
        f"repeat and a target that are reached, over {target_words(findings)}; the area under it "
        "is its mean over all evaluations. The expected running time (ERT) to a target is the "
        "number of evaluations of all repeats, until success or their end, over the number of "
        f"successes (Hansen et al. 2021); its targets are {targets}."
    )


def target_words(findings: Findings) -> str:
    """Return which scores are the targets of the ECDF, such as '51 targets from 0.1 to 2.5'."""
    few = findings.targets
    if len(few) == 1:
        return f"one target, {_short(few[0])}"
    return f"{len(few)} targets from {_short(few[0])} to {_short(few[-1])}"


def to_dict(findings: Findings) -> dict[str, object]:
    """Return the findings as values for JSON."""
    return {
        "evaluations": findings.evaluations,
        "targets": findings.targets.tolist(),
        "experiments": {
            label: {
                **vars(findings.descriptions[label]),
                "seed": one.experiment.seed,
                "evaluations": int(one.evaluations[-1]),
                "area": findings.ecdfs[label].area,
                "area_low": findings.ecdfs[label].low,
                "area_high": findings.ecdfs[label].high,
                "targets_reached": float(findings.ecdfs[label].share[-1]),
                "ert": [
                    {
                        "target": reached.target,
                        "successes": reached.successes,
                        "success_rate": reached.rate,
                        "ert": reached.ert,
                        "ert_low": reached.low,
                        "ert_high": reached.high,
                    }
                    for reached in findings.reached[label]
                ],
            }
            for label, one in findings.samples.items()
        },
        "comparisons": [{**vars(pair), "differs": pair.differs} for pair in findings.pairs],
        "warning": findings.warning or None,
        "methods": methods(findings),
    }


def tables(findings: Findings) -> list[tuple[str, list[str], list[list[str]]]]:
    """Return title, columns and rows of each table of the report."""
    interval = f"{100 * CONFIDENCE:.0f} % CI"
    descriptions = [
        [
            label,
            number(d.median),
            _range(d.median_low, d.median_high),
            _range(d.q25, d.q75),
            _range(d.minimum, d.maximum),
        ]
        for label, d in findings.descriptions.items()
    ]
    pairs = [
        [
            f"{pair.first} against {pair.second}",
            f"{pair.p:.2g}",
            f"{pair.p_holm:.2g}",
            f"{pair.a12:.3f}",
            pair.effect,
            "yes" if pair.differs else "no",
        ]
        for pair in findings.pairs
    ]
    areas = [
        [label, number(one.area), _range(one.low, one.high), f"{100 * one.share[-1]:.0f} %"]
        for label, one in findings.ecdfs.items()
    ]
    reached = [
        [
            _short(r.target, 6),
            label,
            f"{r.successes} of {r.repeats}",
            _count(r.ert),
            "–" if math.isinf(r.ert) else f"{_count(r.low)} to {_count(r.high)}",
        ]
        for few in zip(*findings.reached.values(), strict=True)
        for label, r in zip(findings.reached, few, strict=True)
    ]
    after = f"Best scores after {findings.evaluations:,} evaluations, {findings.repeats} repeats"
    return [
        (after, ["experiment", "median", interval, "quartiles", "range"], descriptions),
        ("Differences", ["pair", "p", "p (Holm)", "A12", "effect", "differs at 5 %"], pairs),
        (
            f"ECDF over {target_words(findings)}",
            ["experiment", "area", interval, "reached at the end"],
            areas,
        ),
        (
            "Expected running times, evaluations",
            ["target", "experiment", "successes", "ERT", interval],
            reached,
        ),
    ]


def _short(value: float, digits: int = 4) -> str:
    return f"{value:.{digits}g}".replace("-", "−")


def _range(low: float, high: float) -> str:
    return f"{number(low)} to {number(high)}"


def _count(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:,.0f}"


def write_comparison(folder: Path, findings: Findings, command: str, figures: list[Path]) -> None:
    """Write the tables of all repeats and of the ECDF, and the report, which shows the figures.

    Args:
        folder: where to write.
        findings: what was found.
        command: the command that repeats the comparison.
        figures: in the folder.

    Raises:
        RunError: a file cannot be written.
    """
    write_bytes(folder / TABLE, results(findings).encode())
    write_bytes(folder / CURVES, curves(findings).encode())
    write_bytes(folder / REPORT, report(findings, command, figures).encode())


def report(findings: Findings, command: str, figures: list[Path]) -> str:
    """Return the comparison as Markdown."""
    lines = ["# " + " against ".join(findings.samples), ""]
    if said := findings.warning:
        lines += [f"**Warning:** {said}", ""]
    for title, columns, rows in tables(findings):
        lines += [f"## {title}", "", *markdown(columns, rows), ""]
    lines += [
        "A12 is how often a score of the first exceeds one of the second, ties half; with 0.5, "
        "neither tends to be higher.",
        "",
    ]
    for figure in figures:
        lines += [f"![{figure.stem}]({figure.name})", ""]
    lines += ["## Methods", "", methods(findings), "", "## Reproduce", "", "```sh", command]
    return "\n".join([*lines, "```", ""])


def results(findings: Findings) -> str:
    """Return the best score so far of every repeat as tidy CSV, at no more than 200 generations."""
    return _csv(
        ("experiment", "repeat", "generation", "evaluations", "best"),
        (
            [label, repeat + 1, at + 1, one.evaluations[at], float(one.best[repeat, at])]
            for label, one in findings.samples.items()
            for repeat in range(len(one.best))
            for at in _kept(one.best.shape[1])
        ),
    )


def curves(findings: Findings) -> str:
    """Return the ECDFs as tidy CSV, at no more than 200 generations."""
    return _csv(
        ("experiment", "evaluations", "share"),
        (
            [label, findings.samples[label].evaluations[at], float(one.share[at])]
            for label, one in findings.ecdfs.items()
            for at in _kept(len(one.share))
        ),
    )


def _kept(generations: int) -> list[int]:
    kept: list[int] = np.unique(
        np.linspace(0, generations - 1, min(MOST_ROWS, generations)).astype(int)
    ).tolist()
    return kept


def _csv(head: tuple[str, ...], rows: Iterator[list[Any]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()
