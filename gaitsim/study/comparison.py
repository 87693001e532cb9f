"""Compare experiments: repeats, statistics, and a report with its methods."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.experiment import (
    Experiment,
    Overrides,
    load_experiment,
    read_outline,
    with_overrides,
)
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.study.differences import differences, scoring_warning
from gaitsim.study.results import markdown
from gaitsim.study.statistics import (
    CONFIDENCE,
    RESAMPLES,
    Comparison,
    Description,
    TargetSummary,
    compare,
    describe,
    summarise_target,
)


@dataclass(frozen=True, eq=False)
class Sample:
    """The repeats of one experiment.

    Attributes:
        experiment: the experiment.
        best: best score so far, (repeats, generations).
    """

    experiment: Experiment
    best: NDArray[np.float64]

    @property
    def evaluations(self) -> NDArray[np.int64]:
        """The number of evaluations of one repeat so far, (generations,)."""
        return self.experiment.individuals * np.arange(1, self.best.shape[1] + 1)

    @property
    def final(self) -> NDArray[np.float64]:
        """The best score of each repeat, (repeats,)."""
        return self.best[:, -1]


@dataclass(frozen=True, eq=False)
class Findings:
    """The results of a comparison, by the labels of the experiments.

    Attributes:
        samples: the repeats.
        descriptions: descriptive statistics of the final scores.
        comparisons: a test of every pair.
        reached: how often, and how soon, the repeats reach the target.
    """

    samples: Mapping[str, Sample]
    descriptions: Mapping[str, Description]
    comparisons: Sequence[Comparison]
    reached: Mapping[str, TargetSummary]

    @property
    def warning(self) -> str:
        """Why the scores do not compare; '' where they do."""
        return warning(one.experiment for one in self.samples.values())


def load_experiments(references: Sequence[str], overrides: Overrides) -> dict[str, Experiment]:
    """Load experiments by label, each with a seed of its own, so that samples are independent.

    A repeated seed becomes the next free one, and a repeated name gets a number.

    Raises:
        GaitsimError: there are fewer than two experiments, or one has problems.
    """
    if len(references) < 2:
        raise GaitsimError(
            "one experiment cannot be compared",
            allowed="two or more, as: gaitsim compare millipede-random millipede-mutation",
        )
    found: dict[str, Experiment] = {}
    seeds: set[int] = set()
    for reference in references:
        experiment = load_experiment(reference, overrides)
        seed = experiment.seed
        while seed in seeds:
            seed = (seed + 1) % 2**63
        seeds.add(seed)
        if seed != experiment.seed:
            experiment = with_overrides(experiment, {"seed": seed})
        label, number = experiment.name, 1
        while label in found:
            number += 1
            label = f"{experiment.name} ({number})"
        found[label] = experiment
    return found


def warning(experiments: Iterable[Experiment]) -> str:
    """Return a warning where the scores of experiments do not compare; '' where they do."""
    outlines = [read_outline(one.to_toml(), one.name) for one in experiments]
    return scoring_warning(differences([[(1, one)] for one in outlines]))


def analyse(samples: Mapping[str, Sample], target: float | None) -> Findings:
    """Describe and compare samples. The default target is the lowest of the medians.

    Raises:
        GaitsimError: a repeat has no finite score to compare.
    """
    for label, one in samples.items():
        if not np.isfinite(one.final).all():
            raise GaitsimError(
                f"every individual failed in a repeat of {label}, which has no score to compare",
                remedy=f"see why with: gaitsim run {one.experiment.name}",
            )
    descriptions = {
        # A stream of its own for each, by seed: the order of experiments does not matter.
        label: describe(one.final, np.random.default_rng([one.experiment.seed, len(one.final)]))
        for label, one in samples.items()
    }
    aim = min(d.median for d in descriptions.values()) if target is None else target
    return Findings(
        samples,
        descriptions,
        compare({label: one.final for label, one in samples.items()}),
        {label: summarise_target(one.best, one.evaluations, aim) for label, one in samples.items()},
    )


def methods(findings: Findings) -> str:
    """Return a paragraph for the methods section of a paper."""
    repeats = next(iter(findings.descriptions.values())).n
    target = next(iter(findings.reached.values())).target
    return (
        f"Each of the {len(findings.samples)} experiments was repeated {repeats} times from "
        f"independent random populations (gaitsim {version('gaitsim')}). The outcome of a repeat "
        "is its best score after the last generation. We report medians with "
        f"{CONFIDENCE:.0%} percentile bootstrap confidence intervals ({RESAMPLES:,} resamples) "
        "and quartiles. Pairs were compared by two-sided Mann–Whitney U tests, corrected for "
        f"{len(findings.comparisons)} comparison{'s' * (len(findings.comparisons) != 1)} by "
        "Holm's procedure, with the Vargha–Delaney A12 as effect size (Arcuri and Briand 2011). "
        f"Success is reaching a best score of {target:.4g}; the expected running time (ERT) is "
        "the number of evaluations spent in all repeats, until success or the end, over the "
        "number of successes (Hansen et al. 2010)."
    )


def to_dict(findings: Findings) -> dict[str, object]:
    """Return the findings as values for JSON."""
    return {
        "experiments": {
            label: {
                **vars(findings.descriptions[label]),
                "seed": one.experiment.seed,
                "evaluations": int(one.evaluations[-1]),
                "target": findings.reached[label].target,
                "success_rate": findings.reached[label].rate,
                "ert": findings.reached[label].ert,
            }
            for label, one in findings.samples.items()
        },
        "comparisons": [{**vars(pair), "differs": pair.differs} for pair in findings.comparisons],
        "warning": findings.warning or None,
        "methods": methods(findings),
    }


def tables(findings: Findings) -> list[tuple[str, list[str], list[list[str]]]]:
    """Return title, columns and rows of each table of the report."""
    descriptions = [
        [
            label,
            str(d.n),
            f"{d.mean:.4f}",
            f"{d.median:.4f}",
            f"{d.median_low:.4f} to {d.median_high:.4f}",
            f"{d.q25:.4f} to {d.q75:.4f}",
            f"{d.minimum:.4f} to {d.maximum:.4f}",
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
        for pair in findings.comparisons
    ]
    reached = [
        [label, f"{r.target:.4g}", f"{r.successes} of {r.repeats}", f"{r.ert:,.0f}"]
        for label, r in findings.reached.items()
    ]
    return [
        (
            "Final scores",
            ["experiment", "repeats", "mean", "median", "95 % of median", "quartiles", "range"],
            descriptions,
        ),
        ("Differences", ["pair", "p", "p (Holm)", "A12", "effect", "differs at 5 %"], pairs),
        ("Reaching the target", ["experiment", "target", "successes", "ERT, evaluations"], reached),
    ]


REPORT, TABLE, FIGURE = "report.md", "results.csv", "convergence.png"


def write_comparison(folder: Path, findings: Findings, command: str) -> None:
    """Write the table of all repeats, and the report, which shows the figure.

    Args:
        folder: where to write.
        findings: what was found.
        command: the command that repeats the comparison.

    Raises:
        RunError: a file cannot be written.
    """
    write_bytes(folder / TABLE, results(findings).encode())
    write_bytes(folder / REPORT, report(findings, command).encode())


def report(findings: Findings, command: str) -> str:
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
        f"![Best score against evaluations]({FIGURE})",
        "",
        "## Methods",
        "",
        methods(findings),
        "",
        "## Reproduce",
        "",
        "```sh",
        command,
        "```",
        "",
    ]
    return "\n".join(lines)


def results(findings: Findings) -> str:
    """Return the best score so far of every repeat as tidy CSV, at no more than 200 generations."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["experiment", "repeat", "generation", "evaluations", "best"])
    for label, one in findings.samples.items():
        last = one.best.shape[1] - 1
        kept = np.unique(np.linspace(0, last, min(200, last + 1)).astype(int))
        writer.writerows(
            [label, repeat + 1, at + 1, one.evaluations[at], float(one.best[repeat, at])]
            for repeat in range(len(one.best))
            for at in kept.tolist()
        )
    return text.getvalue()
