"""The files of a comparison: the report, and tables from which it can be recomputed."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.atomic import write_bytes
from gaitsim.study.comparison import Findings
from gaitsim.study.comparison_report import report

REPORT, TABLE, CURVES = "report.md", "results.csv", "ecdf.csv"


def write_comparison(folder: Path, findings: Findings, command: str, figures: list[Path]) -> None:
    """Write the tables of all repeats and of the ECDF, and the report with its figures.

    Args:
        folder: folder to write to.
        findings: results of the comparison.
        command: command line that repeats the comparison.
        figures: files of the figures, in the folder.
    """
    write_bytes(folder / TABLE, results(findings).encode())
    write_bytes(folder / CURVES, curves(findings).encode())
    write_bytes(folder / REPORT, report(findings, command, figures).encode())


def results(findings: Findings) -> str:
    """Return the best score so far of every repeat as tidy CSV.

    A repeat has a row for its first and last generation, and for each generation in which the
    score changes, so no data is lost.
    """
    return _csv(
        ("experiment", "repeat", "generation", "evaluations", "best"),
        (
            [label, repeat, at + 1, one.evaluations[at], float(best[at])]
            for label, one in findings.samples.items()
            for repeat, best in enumerate(one.best, 1)
            for at in _changes(best)
        ),
    )


def curves(findings: Findings) -> str:
    """Return the ECDFs as tidy CSV, with their first and last generations and every step."""
    return _csv(
        ("experiment", "evaluations", "share"),
        (
            [label, findings.samples[label].evaluations[at], float(one.share[at])]
            for label, one in findings.ecdfs.items()
            for at in _changes(one.share)
        ),
    )


def _changes(values: NDArray[np.float64]) -> list[int]:
    """Return the first and last index, and every index whose value differs from the previous."""
    changed = np.concatenate([[True], values[1:] != values[:-1]])
    changed[-1] = True
    return np.flatnonzero(changed).tolist()


def _csv(head: tuple[str, ...], rows: Iterator[list[Any]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()
