"""The results of a study: one tidy table, and the cheapest cells that reach the target.

The folders of studies and comparisons are summarised, too; their files may be untrusted.
"""

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Literal

import numpy as np

from gaitsim.plugin import GaitsimError, RunError, is_folder, open_regular, read_regular
from gaitsim.plugin.runs import is_locked, sweep, write_bytes, writing
from gaitsim_studies.confirmation import ReachedTarget
from gaitsim_studies.file import EXPERIMENT, POPULATION, STATISTICS, STUDY, Cell, Study, read_study
from gaitsim_studies.running import CELLS, Best, recorded_generations
from gaitsim_studies.runtimes import target_text
from gaitsim_studies.statistics import CONFIDENCE, LEAST_FOR_MEANS

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
        "set, which has no part in the choice; as only cells that pass are reported, their means "
        "are slightly too high on average. The first test of an experiment has a level of "
        f"{100 - error / 2:.4g} %, and each further test half the error of the previous one, so "
        f"all intervals hold together with {100 * CONFIDENCE:g} % confidence (Bonferroni). "
        "'never' means that no cell passes; the cell in brackets has the highest mean of the "
        "sweep, and was also tested with fresh repeats"
    )


def summary(study: Study, found: Iterable[ReachedTarget]) -> tuple[list[str], list[list[str]]]:
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
    reached: Sequence[ReachedTarget] = (),
) -> None:
    """Write the table and the report.

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
    lines = [f"# {study.name}", "", study.description, ""]
    if study.target is not None:
        lines += [f"## {title(study)}", "", *markdown(*summary(study, reached)), ""]
        lines += [f"Rule: {rule(study)}.", ""]
    write_bytes(folder / REPORT, "\n".join(lines).encode(), follow=False)


DEFAULT_FOLDERS = (
    Path("studies"),
    Path("comparisons"),
)  # default folders of `gaitsim study` and `compare`
FIRST = "1.toml"  # the first experiment
MOST_FOLDERS, MOST_ROWS = 2_000, 2_000
LARGEST_REPORT, LARGEST_TABLE = 2**20, 2**28  # bytes
LONGEST = 10_000  # characters of a row of a table
_CELL = re.compile(r"(\d{6,9})-[0-9a-f]{16}\.npy")

Kind = Literal["study", "comparison"]
State = Literal["running", "stopped", "finished", "damaged"]


@dataclass(frozen=True)
class StudyFolder:
    """A summary of a study or a comparison.

    Attributes:
        path: its folder.
        kind: study or comparison.
        state: running (a process is working on it), stopped (a study can be resumed), finished
            (the results are written), or damaged.
        done: number of finished cells of a study.
        total: number of cells of a study; None for a comparison, or if unknown.
        description: description of a study, one line.
        changed: time of the last change of the folder, seconds since 1970.
        problem: reason why the study cannot be read; None if it can.
    """

    path: Path
    kind: Kind
    state: State
    done: int = 0
    total: int | None = None
    description: str = ""
    changed: float = 0.0
    problem: GaitsimError | None = None


def list_folders(places: Iterable[Path] = DEFAULT_FOLDERS) -> list[StudyFolder]:
    """Return the studies and comparisons in some folders, the latest first."""
    found = []
    for place in places:
        try:
            entries = sorted(islice(place.iterdir(), MOST_FOLDERS)) if place.exists() else []
        except OSError as error:
            raise RunError(f"cannot list {place}: {error.strerror}") from None
        found += [one for path in entries if (one := _read(path)) is not None]
    return sorted(found, key=lambda one: (-one.changed, one.path.name))


def _read(path: Path) -> StudyFolder | None:
    """Return the summary of a folder; None if it is neither a study nor a comparison."""
    if path.name.startswith(".") or not is_folder(path):
        return None
    kind: Kind = "study" if os.path.lexists(path / STUDY) else "comparison"
    if kind == "comparison" and not os.path.lexists(path / FIRST):
        return None
    changed = max(_changed(path / name) for name in ("", CELLS, TABLE))
    running = is_locked(path)
    if kind == "comparison":
        written = os.path.lexists(path / REPORT)
        state: State = "running" if running else "finished" if written else "stopped"
        return StudyFolder(path, kind, state, changed=changed)
    try:
        study, _ = read_study(str(path / STUDY))
    except GaitsimError as error:
        return StudyFolder(path, kind, "damaged", changed=changed, problem=error)
    total = len(study.experiments) * math.prod(len(study.values(axis)) for axis in study.axes)
    done = min(_finished(path / CELLS, total), total)
    written = done == total and os.path.lexists(path / TABLE)
    state = "running" if running else "finished" if written else "stopped"
    return StudyFolder(path, kind, state, done, total, study.description, changed)


def _finished(folder: Path, total: int) -> int:
    """Return the number of cells with a file; `gaitsim study` checks whether files are intact."""
    try:
        # A cell may also have files of other versions, which are not reused.
        names = [entry.name for entry in islice(os.scandir(folder), 2 * total + 100)]
    except OSError:
        return 0
    numbers = {int(match[1]) for match in map(_CELL.fullmatch, names) if match}
    return sum(number < total for number in numbers)


def _changed(path: Path) -> float:
    try:
        return path.lstat().st_mtime
    except OSError:
        return 0.0


@dataclass(frozen=True)
class Section:
    """A section of the results: a heading, a table and paragraphs below it.

    Attributes:
        title: heading.
        columns, rows: header and rows of the table; () without a table.
        texts: paragraphs.
        command: command line in the report, or ''.
    """

    title: str
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    texts: tuple[str, ...] = ()
    command: str = ""


def sections(folder: Path) -> list[Section]:
    """Return the results in a folder: the sections of the report, and the cells of a study."""
    found = []
    if os.path.lexists(folder / REPORT):
        try:
            text = read_regular(folder / REPORT, LARGEST_REPORT).decode()
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(f"cannot read {folder / REPORT}: {_reason(error)}") from None
        found = read_report(text)
    if os.path.lexists(folder / STUDY):
        study, _ = read_study(str(folder / STUDY))
        if os.path.lexists(folder / TABLE):
            found.append(_cells(folder / TABLE, study))
    return found


def read_report(text: str) -> list[Section]:
    """Return the sections of a report that `gaitsim study` or `compare` wrote."""
    found = []
    for part in re.split(r"^#{1,2} ", text, flags=re.MULTILINE)[1:]:
        title, _, body = part.partition("\n")
        blocks = [block.strip() for block in body.split("\n\n") if block.strip()]
        tables = [block for block in blocks if block.startswith("|")]
        commands = [block.strip("`").removeprefix("sh\n").strip()
                    for block in blocks if block.startswith("```")]  # fmt: skip
        texts = [" ".join(block.replace("**", "").split())
                 for block in blocks if not block.startswith(("|", "```", "!["))]  # fmt: skip
        rows = [_row(line) for table in tables[:1] for line in table.split("\n")[: MOST_ROWS + 2]]
        width = len(rows[0]) if rows else 0
        kept = tuple(row for row in rows[2:] if len(row) == width)
        found.append(Section(title, rows[0] if rows else (), kept, tuple(texts), "".join(commands)))
    return found


def _row(line: str) -> tuple[str, ...]:
    cells = re.split(r"(?<!\\)\|", line[:LONGEST].strip().strip("|"))
    return tuple(cell.strip().replace("\\|", "|") for cell in cells)


def _cells(path: Path, study: Study) -> Section:
    """Return the last recorded generation of each cell, with intervals."""
    axes = ("experiment", *study.axes)
    latest: dict[tuple[str, ...], Sequence[str]] = {}
    try:
        with io.TextIOWrapper(open_regular(path, LARGEST_TABLE), encoding="utf-8") as file:
            rows = csv.reader(iter(lambda: file.readline(LONGEST), ""))
            head = next(rows, [])
            if tuple(head) != (*axes, "generation", "evaluations", "repeats", *STATISTICS):
                raise ValueError("its columns do not match the study")
            for row in rows:
                key = tuple(row[: len(axes)])
                if len(row) == len(head) and (key in latest or len(latest) <= MOST_ROWS):
                    latest[key] = row
    except (OSError, ValueError, csv.Error) as error:
        remedy = f"recreate it with: gaitsim study {path.parent}"
        raise RunError(f"cannot read {path}: {_reason(error)}", remedy=remedy) from None
    columns = (*axes, "generations", "repeats", "mean ± 95 %", "median", "quartiles", "range")
    shown = tuple((*key, *_statistics(row[len(axes) :])) for key, row in latest.items())
    more = f"Only the first {MOST_ROWS:,} cells are shown. " if len(shown) > MOST_ROWS else ""
    about = (
        f"{more}Best scores after the last generation of each cell. ± is the 95 % confidence "
        f"interval (Student's t) of each single mean, from {LEAST_FOR_MEANS} repeats on; the "
        f"highest of many means is usually too high by chance. {TABLE} has every recorded "
        "generation."
    )
    return Section("Cells", columns, shown[:MOST_ROWS], (about,))


def _reason(error: Exception) -> str:
    """Return why a file cannot be read, for messages."""
    if isinstance(error, UnicodeDecodeError):
        return "it is not a text file in UTF-8"
    return str(error.strerror if isinstance(error, OSError) else error)


def _statistics(row: Sequence[str]) -> tuple[str, ...]:
    """Return the shown columns of a row: generation, repeats and statistics."""
    from scipy.special import stdtrit

    try:
        generation, repeats = int(row[0]), int(row[2])
        mean, std, median, low, high, least, most = map(float, row[3:])
    except ValueError:
        return (*row[:1], *row[2:3], "–", "–", "–", "–")
    half = math.nan
    if repeats >= LEAST_FOR_MEANS:
        half = float(stdtrit(repeats - 1, 0.975)) * std / math.sqrt(repeats)
    return (
        str(generation),
        str(repeats),
        f"{_number(mean)} ± {_number(half)}" if math.isfinite(half) else _number(mean),
        _number(median),
        f"{_number(low)} to {_number(high)}",
        f"{_number(least)} to {_number(most)}",
    )


def _number(value: float) -> str:
    return f"{value:z.4f}".replace("-", "−") if math.isfinite(value) else "–"
