"""The report of a comparison: tables, a paragraph on methods, JSON, and the files with them."""

import csv
import io
import math
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.runs import write_bytes
from gaitsim_studies.comparison import Findings
from gaitsim_studies.results import markdown, number
from gaitsim_studies.runtimes import DIGITS, target_text
from gaitsim_studies.statistics import (
    CONFIDENCE,
    EXACT,
    LEAST,
    LEAST_FOR_MEANS,
    PairTest,
    TargetTest,
)


class ReportTable(NamedTuple):
    """A table of the report.

    Attributes:
        title: heading.
        columns, rows: cells.
        note: explanation below the table, or ''.
    """

    title: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""


def methods(findings: Findings) -> str:
    """Return a paragraph for the methods section of a paper."""
    targets = ", ".join(map(target_text, findings.ert_targets))
    digits = ""
    if not findings.targets_given:
        digits = f" to {DIGITS} digits of their range (numpy.quantile, method 'inverted_cdf')"
    warning = f" Warning: {findings.warning}" if findings.warning else ""
    return (
        f"Each of the {len(findings.samples)} experiments was repeated {findings.repeats} times "
        f"with {findings.evaluations:,} evaluations and its own random numbers (gaitsim "
        f"{version('gaitsim')}); a score counts once its generation is finished. The outcome of a "
        f"repeat is its best score; a repeat without a finite score ranks below all others. We "
        "report medians and quartiles (interpolated linearly). Pairs of experiments were compared "
        f"with two-sided Mann–Whitney U tests ({_exactness(findings)}), and the Vargha–Delaney A12 "
        "as effect size (Arcuri and Briand 2011). The ECDF of runtimes is the share of pairs of a "
        f"repeat and a target in which the repeat has reached the target, over "
        f"{target_words(findings)}, {findings.ecdf_rule}; the area under the ECDF "
        "is its mean over all evaluations. The expected running time (ERT) to a target is the "
        "number of evaluations of all repeats, until success or their end, divided by the number "
        f"of successes (Hansen et al. 2021). Its targets are {targets}, "
        f"{findings.ert_rule}{digits}. "
        "At each target, successes were compared with two-sided Fisher's exact tests, and numbers "
        "of evaluations until success with the same Mann–Whitney test and A12, in which all "
        "repeats without success tie after all others (Gehan 1965). The p-values of all "
        f"{findings.tests} tests, of scores, successes and times, were corrected together with "
        f"Holm's procedure. {100 * CONFIDENCE:.0f} % confidence intervals are those of order "
        "statistics for medians, of Clopper and Pearson (1934) for success rates, of Student's t "
        "after Hall's transformation (1992) for areas, and, for A12, the wider of those of DeLong "
        "et al. (1988) on the logit scale and of Newcombe (2006, method 5). The interval of an ERT "
        "combines those of the success rate and of the mean time of successes (Zou and Donner "
        f"2008). The intervals are not corrected for their number.{warning}"
    )


def _exactness(findings: Findings) -> str:
    if 2 * findings.repeats <= EXACT:
        return "exact, conditional on ties"
    return "normal approximation with corrections for ties and continuity"


def target_words(findings: Findings) -> str:
    """Return a description of the targets of the ECDF, such as '51 targets from 0.1 to 2.5'."""
    # Chosen targets have many digits; four suffice to describe their range.
    values = findings.targets if findings.targets_given else map(_rounded, findings.targets)
    texts = [target_text(value) for value in values]
    if len(texts) == 1:
        return f"one target, {texts[0]}"
    return f"{len(texts)} targets from {texts[0]} to {texts[-1]}"


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def to_dict(findings: Findings) -> dict[str, object]:
    """Return the findings as values for JSON."""
    return {
        "evaluations": findings.evaluations,
        "repeats": findings.repeats,
        "targets": findings.targets.tolist(),
        "targets_chosen": findings.ecdf_rule,
        "ert_targets": findings.ert_targets,
        "ert_targets_chosen": findings.ert_rule,
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
                        "success_rate_low": reached.rate_low,
                        "success_rate_high": reached.rate_high,
                        "ert": reached.ert,
                        "ert_low": reached.low,
                        "ert_high": reached.high,
                    }
                    for reached in findings.reached[label]
                ],
            }
            for label, one in findings.samples.items()
        },
        "comparisons": [pair.to_dict() for pair in findings.pairs],
        "target_comparisons": [test.to_dict() for test in findings.target_tests],
        "notes": findings.notes,
        "warning": findings.warning or None,
        "methods": methods(findings),
    }


def tables(findings: Findings) -> list[ReportTable]:
    """Return the tables of the report."""
    interval = f"{100 * CONFIDENCE:.0f} % CI"
    descriptions = [
        [
            label,
            _score(d.median),
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
            *_effect(pair),
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
            target_text(r.target),
            label,
            f"{r.successes} of {r.repeats}",
            f"{100 * r.rate_low:.0f} to {100 * r.rate_high:.0f} %",
            _count(r.ert),
            "–" if math.isnan(r.low) else f"{_count(r.low)} to {_count(r.high)}",
        ]
        for few in zip(*findings.reached.values(), strict=True)
        for label, r in zip(findings.reached, few, strict=True)
    ]
    target_tests = [
        [
            target_text(one.target),
            f"{one.first} against {one.second}",
            f"{one.p_success:.2g} ({one.p_success_holm:.2g})",
            f"{one.p_time:.2g} ({one.p_time_holm:.2g})",
            *_effect(one),
            _verdict(one),
        ]
        for one in findings.target_tests
    ]
    # The warning is repeated below the effect sizes, which are misleading without it.
    caution = f"{findings.warning} " if findings.warning else ""
    few = ""
    if LEAST <= findings.repeats < LEAST_FOR_MEANS:
        few = f" Areas have no interval with fewer than {LEAST_FOR_MEANS} repeats."
    after = f"Best scores after {findings.evaluations:,} evaluations, {findings.repeats} repeats"
    return [
        ReportTable(after, ["experiment", "median", interval, "quartiles", "range"], descriptions),
        ReportTable(
            "Differences",
            ["pair", "p", "p (Holm)", "A12", interval, "effect", "differs at 5 %"],
            pairs,
            f"{caution}A12 is the share of pairs of scores in which the first experiment's score "
            "is higher; ties count half. It is 0.5 if neither tends to be higher. An effect is "
            f"named only if the whole interval agrees. Holm's procedure corrects all "
            f"{findings.tests} tests of this report together.",
        ),
        ReportTable(
            f"ECDF over {target_words(findings)}",
            ["experiment", "area", interval, "reached at the end"],
            areas,
            f"Targets: {findings.ecdf_rule}.{few}",
        ),
        ReportTable(
            "Successes and expected running times (ERT), evaluations",
            ["target", "experiment", "successes", f"rate, {interval}", "ERT", f"ERT, {interval}"],
            reached,
            f"Targets: {findings.ert_rule}.",
        ),
        ReportTable(
            "Differences at the targets",
            [
                "target",
                "pair",
                "successes: p (Holm)",
                "times: p (Holm)",
                "A12",
                interval,
                "effect",
                "differs at 5 %",
            ],
            target_tests,
            f"{caution}A12 is the share of pairs of repeats in which the first experiment's repeat "
            "reaches the target sooner; ties count half, and repeats that never reach it tie.",
        ),
    ]


def _verdict(test: TargetTest) -> str:
    match test.success_differs, test.time_differs:
        case True, True:
            return "both"
        case True, False:
            return "successes"
        case False, True:
            return "times"
    return "no"


def _effect(test: PairTest | TargetTest) -> list[str]:
    return [f"{test.a12:.3f}", _range(test.a12_low, test.a12_high), test.effect or "–"]


def _range(low: float, high: float) -> str:
    return "–" if math.isnan(low) else f"{_score(low)} to {_score(high)}"


def _score(value: float) -> str:
    """Return a score as text; 'failed' for that of a repeat in which every individual failed."""
    return "failed" if math.isinf(value) else number(value)


def _count(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:,.0f}"


def report(findings: Findings, command: str, figures: list[Path]) -> str:
    """Return the comparison as Markdown."""
    lines = ["# " + " against ".join(findings.samples), ""]
    for heading, text in remarks(findings):
        lines += [f"**{heading}** {text}", ""]
    for title, columns, rows, note in tables(findings):
        lines += [f"## {title}", "", *markdown(columns, rows), ""]
        lines += [note, ""] if note else []
    for figure in figures:
        lines += [f"![{figure.stem}]({figure.name})", ""]
    files = [
        [f"{place}.toml", label, str(one.experiment.seed)]
        for place, (label, one) in enumerate(findings.samples.items(), 1)
    ]
    lines += ["## Methods", "", methods(findings), "", "## Reproduce", ""]
    lines += [*markdown(["file", "experiment", "seed"], files), "", "```sh", command]
    return "\n".join([*lines, "```", ""])


def remarks(findings: Findings) -> list[tuple[str, str]]:
    """Return the warnings and notes that precede the tables, as pairs of heading and text."""
    warning = [("Warning:", findings.warning)] if findings.warning else []
    return [*warning, *(("Note:", note) for note in findings.notes)]


REPORT, TABLE, CURVES, VALUES = "report.md", "results.csv", "ecdf.csv", "comparison.json"


def write_comparison(folder: Path, findings: Findings, command: str, figures: list[Path]) -> None:
    """Write the tables of all repeats and of the ECDF, and the report with its figures."""
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
