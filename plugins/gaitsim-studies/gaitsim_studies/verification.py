"""Verify studies and comparisons: they are computed again in another folder, and compared.

Of a long one, the scores of a random part are computed again, and the rest is taken as it is.
"""

import csv
import io
import json
import os
import re
import secrets
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version
from itertools import count, islice, takewhile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, get_args

import numpy as np
from pydantic_core import to_json

from gaitsim.plugin import (
    ComparisonPlot,
    GaitsimError,
    PlotFormat,
    RunError,
    is_folder,
    read_regular,
)
from gaitsim.plugin.runs import (
    Experiment,
    FileDifference,
    Verdict,
    Verifier,
    check_links,
    check_no_atlas,
    compare_folders,
    file_results,
)
from gaitsim_studies.comparison import (
    Sample,
    analyse,
    check_request,
    equal_budgets,
    experiment_texts,
    load_experiments,
)
from gaitsim_studies.comparison_report import CURVES, VALUES, report, to_dict, write_comparison
from gaitsim_studies.confirmation import confirm
from gaitsim_studies.file import MOST_SCORES, STUDY, Cell, Study, cells, read_study
from gaitsim_studies.results import (
    FIRST,
    LARGEST_REPORT,
    LARGEST_TABLE,
    REPORT,
    TABLE,
    write_results,
)
from gaitsim_studies.running import (
    CELLS,
    FRESH,
    complete_repeats,
    read_result,
    recorded_generations,
    results,
    run_cells,
    write_result,
)

SAMPLES = 10
"""Number of cells of a study that are run again by default."""
REPEATS = 3
"""Number of repeats of each experiment of a comparison that are evolved again by default."""

OnSteps = Callable[[int], object]


def choose(numbers: Sequence[int], most: int) -> list[int]:
    """Return at most `most` of the numbers, drawn so that nobody can foresee them, in order."""
    return sorted(secrets.SystemRandom().sample(numbers, min(most, len(numbers))))


def verify_study(
    folder: Path,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: OnSteps = lambda total: None,
    advance: OnSteps = lambda steps: None,
) -> Verdict:
    """Run cells of a study again, and compare its results, table and report.

    Args:
        folder: folder of the study, which is not changed.
        everything: whether to run all cells and the fresh repeats again, rather than `SAMPLES`
            random cells.
        workers: number of processes; None for one per core.
        begin: callback with the number of cells to run.
        advance: callback with the number of cells run since the last call.
    """
    check_links(folder)
    study, _ = read_study(str(folder / STUDY))
    every = cells(study, folder, str(folder / STUDY))
    here = {cell.index: read_result(folder, study, cell) for cell in every}
    present = [cell.index for cell in every if here[cell.index] is not None]
    if not present:
        raise RunError(
            f"the study {folder} has no cell that the installed versions have computed",
            remedy="run it with the versions that evolved it",
        )
    finished = (folder / TABLE).exists()
    chosen = present if everything else choose(present, SAMPLES)
    begin(len(chosen))
    with TemporaryDirectory() as temporary:
        there = Path(temporary, "study")
        (there / CELLS).mkdir(parents=True)
        for cell in every if not everything else ():
            if cell.index not in chosen and (best := here[cell.index]) is not None:
                write_result(there, study, cell, best)
        if not everything:
            _copy_fresh(folder, there, study, every)
        again = [cell for cell in every if cell.index in chosen]
        for _cell in run_cells(there, study, again, workers):
            advance(1)
        found = [
            FileDifference(f"{CELLS}/", f"cell {cell.index} is missing or damaged")
            for cell in every
            if finished and here[cell.index] is None
        ]
        if finished and not found:
            scores, _ = results(there, study, every)
            write_results(there, study, scores, confirm(there, study, scores, workers))
        found += compare_folders(folder, there)
        compared = {CELLS: f"{CELLS}/", FRESH: f"{FRESH}/"}
        files = {
            compared.get(path.name, path.name): "computed again" for path in sorted(there.iterdir())
        }
    files[f"{CELLS}/"] = f"{len(chosen):,} of {len(every):,} run again"
    notes = []
    unknown = {}
    if not everything and study.target is not None:
        unknown[f"{FRESH}/"] = f"agrees with {REPORT}, but was not run again; --all does so"
    if not everything and len(chosen) < len(every):
        unknown[f"{CELLS}/"] = files.pop(f"{CELLS}/")
    if not finished:
        notes.append("the study is not finished: it has no table and no report to compare")
    options = dict.fromkeys([STUDY, *(f"{at}.toml" for at, _ in enumerate(study.experiments, 1))],
                            "fits the keys of the results")  # fmt: skip
    return Verdict(
        "study",
        "cells run",
        len(every),
        tuple(chosen),
        len(chosen) == len(every) and not notes and not unknown,
        tuple(found),
        file_results(found, options | files, unknown),
        tuple(notes),
    )


def _copy_fresh(folder: Path, there: Path, study: Study, every: Sequence[Cell]) -> None:
    """Copy the results of fresh repeats; a folder may hold pipes and huge files."""
    if not is_folder(folder / FRESH):
        return
    (there / FRESH).mkdir()
    recorded = (recorded_generations(one.experiment, study.record_every) for one in every)
    largest = 8 * study.fresh.repeats * max(map(len, recorded)) + 1000
    for file in islice((folder / FRESH).iterdir(), 2 * len(every) + 1000):
        if re.fullmatch(r"\d{6,9}-[0-9a-f]{16}\.npy", file.name):
            with suppress(OSError):
                (there / FRESH / file.name).write_bytes(read_regular(file, largest))


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
    begin: OnSteps = lambda total: None,
    advance: OnSteps = lambda steps: None,
) -> Verdict:
    """Evolve repeats again, and compute all tables and the report from them.

    Args:
        folder: folder of the comparison, which is not changed.
        everything: whether to evolve all repeats again, rather than `REPEATS` random ones of each
            experiment; a search that handles several populations at once evolves all.
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
    loaded, repeats = load_experiments(files, {}), request.repeats
    budget, shortened = equal_budgets(loaded, request.evaluations)
    samples = _read_samples(folder / TABLE, shortened, repeats)
    several = everything or any(one.search.several for one in shortened.values())
    chosen = choose(range(repeats), repeats if several else REPEATS)
    begin(sum(len(chosen) * one.evolution.generations for one in shortened.values()))
    found = []
    with TemporaryDirectory() as temporary:
        there, parts = Path(temporary, "comparison"), Path(temporary, "repeats")
        there.mkdir()
        parts.mkdir()
        for place, (label, sample) in enumerate(samples.items(), 1):
            best = sample.best.copy()
            best[chosen] = np.nan
            complete_repeats(
                parts, place, sample.experiment, best, workers=workers, on_generation=advance
            )
            wrong = np.flatnonzero((best != sample.best).any(axis=1))
            found += [FileDifference(TABLE, f"repeat {at + 1} of {label} differs") for at in wrong]
        findings = analyse(samples, budget, request.targets)
        for name, text in experiment_texts(shortened).items():
            (there / name).write_text(text)
        figures = [folder / f"{kind}.{request.format}" for kind in get_args(ComparisonPlot)]
        write_comparison(there, findings, request.command, [])
        (there / REPORT).write_text(report(findings, request.command, figures))
        found += compare_folders(folder, there)
    # Figures are listed in the report, which links to them.
    found += [FileDifference(one.name, "is missing") for one in figures if not os.path.lexists(one)]
    again = json.loads(to_json(to_dict(findings), inf_nan_mode="null"))
    if json.loads(values) != {**again, "command": request.command}:
        found.append(FileDifference(VALUES, "differs when computed again"))
    rest = repeats - len(chosen)
    table = {TABLE: f"{len(chosen)} of {repeats} repeats of each experiment evolved again"}
    compared = dict.fromkeys(experiment_texts(shortened), "")
    compared |= dict.fromkeys([CURVES, VALUES, REPORT], f"computed again from {TABLE}")
    unknown = {one.name: f"whether it shows {TABLE}" for one in figures}
    return Verdict(
        "comparison",
        "repeats of each experiment evolved",
        repeats,
        tuple(at + 1 for at in chosen),
        not rest,
        tuple(found),
        file_results(
            found, compared if rest else table | compared, table | unknown if rest else unknown
        ),
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
    file: Path, experiments: Mapping[str, Experiment], repeats: int
) -> dict[str, Sample]:
    """Return the repeats in the table of a comparison, which lists only changes of the score."""
    if repeats * sum(one.evolution.generations for one in experiments.values()) > MOST_SCORES:
        raise RunError(f"the comparison {file.parent} has more than {MOST_SCORES:,} scores")
    best = {
        label: np.full((repeats, one.evolution.generations), np.nan)
        for label, one in experiments.items()
    }
    try:
        for row in csv.DictReader(io.StringIO(_read(file, LARGEST_TABLE))):
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


def _without_atlas(verify: Callable[..., Verdict]) -> Callable[..., Verdict]:
    def call(path: Path, *, atlas: str | None, **options: Any) -> Verdict:
        check_no_atlas(atlas)
        return verify(path, **options)

    return call


# Unlike pathlib, os.path accepts names that are invalid for files.
def _is_study(path: Path) -> bool:
    return os.path.lexists(path / STUDY)


STUDIES = Verifier(_is_study, _without_atlas(verify_study))
COMPARISONS = Verifier(  # a study has such a file, too
    lambda path: os.path.lexists(path / FIRST) and not _is_study(path),
    _without_atlas(verify_comparison),
)
