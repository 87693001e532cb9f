"""Verify a comparison: repeats are evolved again, and its tables and report are computed again."""

import csv
import io
import json
import os
import re
import shlex
from collections.abc import Callable, Mapping
from importlib.metadata import version
from itertools import count, takewhile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple, get_args

import numpy as np
from pydantic_core import to_json

from gaitsim.plugin import ComparisonPlot, GaitsimError, PlotFormat, RunError, read_regular
from gaitsim.plugin.runs import Account, Experiment, FilesVerdict, check_links
from gaitsim_studies.comparison import (
    Sample,
    analyse,
    check_request,
    equal_budgets,
    experiment_texts,
    load_experiments,
)
from gaitsim_studies.comparison_report import CURVES, VALUES, curves, report, results, to_dict
from gaitsim_studies.file import MOST_SCORES
from gaitsim_studies.results import LARGEST_REPORT, LARGEST_TABLE, REPORT, TABLE
from gaitsim_studies.running import complete_repeats

SAMPLES = 3
"""Number of repeats of each experiment that are evolved again by default."""

_COMMAND = re.compile(
    r"gaitsim\0compare\0(?P<files>.+)\0--repeats\0(?P<repeats>\d{1,6})"
    r"(\0--targets=(?P<targets>[^\0]*))?(\0--format\0(?P<format>\w+))?"
    r"\0--evaluations\0(?P<evaluations>\d{1,18})"
)


class _Request(NamedTuple):
    """The options of a comparison, as read from its command."""

    command: str
    repeats: int
    targets: tuple[float, ...]
    format: str
    evaluations: int


def verify_comparison(
    folder: Path,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[int], None] = lambda steps: None,
) -> FilesVerdict:
    """Evolve repeats again, and compute all tables and the report again from `results.csv`.

    Args:
        folder: folder of the comparison, which is not changed.
        everything: whether to evolve all repeats again, rather than `SAMPLES` of each experiment;
            a search that handles several populations at once evolves all.
        workers: number of workers; None for the bodies' defaults.
        begin: callback with the number of generations to evolve.
        advance: callback with the number of generations evolved since the last call.
    """
    check_links(folder)
    places = takewhile(lambda place: os.path.lexists(folder / f"{place}.toml"), count(1))
    files = [folder / f"{place}.toml" for place in places]
    if not os.path.lexists(folder / REPORT):
        raise RunError(
            f"the comparison {folder} is not finished: it has no {REPORT}",
            remedy="repeat its command, which continues it",
        )
    values = _read(folder / VALUES, LARGEST_REPORT)
    request = _read_request(folder, values, len(files))
    loaded = load_experiments(files, {})
    budget, shortened = equal_budgets(loaded, request.evaluations)
    found = [
        f"{name} is not as the comparison wrote it"
        for name, text in experiment_texts(shortened).items()
        if _read(folder / name, LARGEST_REPORT) != text
    ]
    table = _read(folder / TABLE, LARGEST_TABLE)
    samples = _read_samples(folder / TABLE, table, shortened, request.repeats)
    repeats = np.arange(request.repeats)
    some = np.unique(np.linspace(0, repeats[-1], SAMPLES).round().astype(int))
    several = any(one.search.several for one in shortened.values())
    chosen = repeats if everything or several else some
    begin(sum(len(chosen) * one.evolution.generations for one in shortened.values()))
    with TemporaryDirectory() as temporary:
        for place, (label, sample) in enumerate(samples.items(), 1):
            best = sample.best.copy()
            best[chosen] = np.nan
            complete_repeats(
                Path(temporary), place, sample.experiment, best,
                workers=workers, on_generation=advance,
            )  # fmt: skip
            wrong = np.flatnonzero((best != sample.best).any(axis=1))
            found += [f"{TABLE}: repeat {at + 1} of {label} differs" for at in wrong.tolist()]
    findings = analyse(samples, budget, request.targets)
    # Figures are listed in the report, which links to them.
    figures = [folder / f"{kind}.{request.format}" for kind in get_args(ComparisonPlot)]
    found += [f"{one.name} is missing" for one in figures if not os.path.lexists(one)]
    again = json.loads(to_json(to_dict(findings), inf_nan_mode="null"))
    texts = {
        TABLE: (table, results(findings)),
        CURVES: (_read(folder / CURVES, LARGEST_TABLE), curves(findings)),
        REPORT: (
            _read(folder / REPORT, LARGEST_REPORT),
            report(findings, request.command, figures),
        ),
        VALUES: (json.loads(values), {**again, "command": request.command}),
    }
    found += [
        f"{name} does not follow from the repeats"
        for name, (then, now) in texts.items()
        if then != now
    ]
    return FilesVerdict(
        "comparison",
        "repeats of each experiment evolved",
        request.repeats,
        tuple((chosen + 1).tolist()),
        len(chosen) == request.repeats,
        tuple(found),
        _accounts(len(files), len(chosen), request.repeats, [one.name for one in figures]),
    )


def _accounts(
    experiments: int, again: int, repeats: int, figures: list[str]
) -> tuple[Account, ...]:
    """Return the comparisons of each file of a comparison."""
    rest, computed = repeats - again, f"computed again from {TABLE}"
    return (
        Account(f"1.toml to {experiments}.toml", "evolved again from them", "descriptions"),
        Account(
            TABLE,
            f"{again} of {repeats} repeats of each experiment evolved again",
            f"the other {rest}" if rest else "",
        ),
        Account(CURVES, computed),
        Account(VALUES, computed, "the folder in its command"),
        Account(REPORT, computed),
        Account(" and ".join(figures), "not compared", f"whether they show {TABLE}"),
    )


def _read_request(folder: Path, values: str, experiments: int) -> _Request:
    """Return the options in the command of a comparison, given its number of experiments.

    Raises:
        RunError: the command or the version of gaitsim in `comparison.json` are not as expected.
    """
    remedy = "restore the file, or repeat the comparison in another folder"
    try:
        content = json.loads(values)
        line, methods = str(content["command"]), str(content["methods"])
        match = _COMMAND.fullmatch("\0".join(shlex.split(line)))
        if match is None:
            raise ValueError("its command is not that of a comparison")
        files = match["files"].split("\0")
        before = files[0].removesuffix("1.toml")
        if files != [f"{before}{place}.toml" for place in range(1, experiments + 1)]:
            raise ValueError(f"its command does not name all of the {experiments} experiments")
        targets = check_request(match["targets"], None, None)
        format, repeats = match["format"] or "png", int(match["repeats"])
        if format not in get_args(PlotFormat) or repeats < 2:
            raise ValueError("its command has an invalid option")
    except (ValueError, KeyError, TypeError, RecursionError, GaitsimError) as error:
        reason = f"it has no {error}" if isinstance(error, KeyError) else str(error)
        raise RunError(f"{folder / VALUES} is damaged: {reason}", remedy=remedy) from None
    own, used = version("gaitsim"), re.search(r"\(gaitsim ([\w.+!-]{1,40})\)", methods)
    if used is None or used[1] != own:
        other = f"gaitsim {used[1]}" if used else "an unknown version of gaitsim"
        raise RunError(
            f"the comparison {folder} was made by {other}, and this is gaitsim {own}",
            remedy="verify it with the same version",
        )
    return _Request(line, repeats, targets, format, int(match["evaluations"]))


def _read(file: Path, largest: int) -> str:
    """Return the text in a file of a comparison."""
    try:
        return read_regular(file, largest).decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text in UTF-8"
        raise RunError(f"cannot read {file}: {reason}") from None


def _read_samples(
    file: Path, text: str, experiments: Mapping[str, Experiment], repeats: int
) -> dict[str, Sample]:
    """Return the repeats in the table of a comparison, which lists only changes of the score."""
    if repeats * sum(one.evolution.generations for one in experiments.values()) > MOST_SCORES:
        raise RunError(f"the comparison {file.parent} has more than {MOST_SCORES:,} scores")
    best = {
        label: np.full((repeats, one.evolution.generations), np.nan)
        for label, one in experiments.items()
    }
    try:
        for row in csv.DictReader(io.StringIO(text)):
            at = int(row["repeat"]) - 1, int(row["generation"]) - 1
            best[row["experiment"]][at] = float(row["best"])
    except (KeyError, IndexError, TypeError, ValueError, csv.Error) as error:
        raise RunError(f"{file} is damaged: invalid value {error}") from None
    for label, scores in best.items():
        if np.isnan(scores[:, 0]).any():
            raise RunError(f"{file} is damaged: a repeat of {label} is missing")
        listed = np.where(np.isnan(scores), 0, np.arange(scores.shape[1]))
        latest = np.maximum.accumulate(listed, axis=1)
        best[label] = np.take_along_axis(scores, latest, axis=1)
    return {label: Sample(one, best[label]) for label, one in experiments.items()}
