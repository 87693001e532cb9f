"""Overviews of runs, and a list of them that is quick to read.

This module imports nothing heavy, so that `gaitsim runs` starts quickly.
"""

import csv
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from itertools import islice
from pathlib import Path
from typing import Any

from gaitsim import toml
from gaitsim.errors import GaitsimError, RunError
from gaitsim.opening import open_regular, read_regular
from gaitsim.registry import KINDS
from gaitsim.stopping import SearchProgress, stop_reason
from gaitsim.storage.background import (
    RunState,
    background_process,
    last_failure,
    runtime_names,
    status_names,
)
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.folder import (
    CHECKPOINT,
    EXPERIMENT,
    HISTORY,
    last_modified,
    list_runs,
)
from gaitsim.storage.lock import is_locked
from gaitsim.storage.manage import read_note, read_tags

LARGEST = 2**30  # bytes of a history that is read
TAIL = 2**16  # bytes at the end of a history that contain the last row
_HEAD = b"generation,stage,evaluations,best,mean,median,lower quartile,upper quartile,worst,std,"
_HEAD += b"diversity,seconds"
_SECONDS = _HEAD.count(b",")
_MEAN = "mean:"

LISTED: tuple[RunState, ...] = (
    "running",
    "queued",
    "paused",
    "stopped",
    "failed",
    "finished",
    "older format",
    "newer format",
    "damaged",
)
"""The states of runs in lists; a run that is prepared or written elsewhere is running."""


@dataclass(frozen=True)
class Overview:
    """An overview of a run.

    Attributes:
        path: folder of the run.
        state: state of the run, one of `LISTED`.
        plugins: name of each plugin by kind.
        description: description of the experiment.
        seed: seed of the experiment.
        generation: last finished generation.
        generations: number of planned generations.
        best: best score among those comparable with the last generation; None before the first
            generation, or if all individuals failed.
        stage: number of the current stage, counted from 1.
        seconds: duration of the evolution.
        changed: time of the last change, in seconds since 1970.
        curve: best score over the generations, thinned; NaN where all failed.
        problem: error that prevents reading the run; None if it can be read.
        failure: error of its background process; None if that did not fail.
        note: note of the user, or the reason why it cannot be read, in parentheses.
        tags: tags of the user, sorted.
        evaluations: number of individuals evaluated so far.
        options: options of the experiment by dotted key.
        terms: terms of the best individual of the last generation.
    """

    path: Path
    state: RunState
    plugins: Mapping[str, str]
    description: str = ""
    seed: int = 0
    generation: int = 0
    generations: int = 0
    best: float | None = None
    stage: int = 1
    seconds: float = 0.0
    changed: float = 0.0
    curve: tuple[float, ...] = ()
    problem: GaitsimError | None = None
    failure: GaitsimError | None = None
    note: str = ""
    tags: tuple[str, ...] = ()
    evaluations: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)
    terms: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of the run's folder."""
        return self.path.name

    @property
    def evolves(self) -> bool:
        """Whether a process is evolving the run, or waiting to."""
        return self.state in ("running", "paused", "queued")


def list_overviews(
    root: Path,
    read_in_full: Callable[[Path], Overview | None],
    *,
    times: bool = True,
    each: Callable[[Sequence[Path]], Iterable[Path]] = iter,
) -> list[Overview]:
    """Return the runs in a folder, oldest first, in a form for lists.

    The curve may be left out. Of a run with an intact checkpoint, neither the arrays nor all values
    in the history are checked. This takes a fifth of the time of `growing.overview`, and saves the
    imports of that, 0.25 s.

    Args:
        root: path of the folder.
        read_in_full: function that reads another run, which is `growing.overview`.
        times: whether the duration is needed, which takes 1.5 µs per generation; 0 otherwise.
        each: function that yields the runs to read, and may show the progress.
    """
    names = runtime_names()
    found = (
        _read_quickly(path, names, times=times) or read_in_full(path)
        for path in each(list_runs(root))
    )
    return [run for run in found if run is not None]


def run_state(
    run: Path, *, finished: bool, background: bool
) -> tuple[RunState, GaitsimError | None]:
    """Return the state of a run, and the failure of its background process.

    Args:
        run: folder of the run.
        finished: whether a stop condition holds.
        background: whether a background process of the run has left files.
    """
    process = background_process(run) if background else None
    if process is not None and process.state in ("queued", "paused"):
        return process.state, None
    if process is not None or is_locked(run):
        return "running", None
    failure = last_failure(run) if background else None
    return "failed" if failure else "finished" if finished else "stopped", failure


def annotations(run: Path) -> tuple[str, tuple[str, ...]]:
    """Return the note of a run, or in parentheses why it cannot be read, and its tags."""
    try:
        note = read_note(run)
    except RunError as error:
        note = f"({error.what})"
    with suppress(RunError):
        return note, read_tags(run)
    return note, ()


def terms_of(row: Mapping[str, float]) -> dict[str, float]:
    """Return the terms of the best individual in a row of a history, without NaN."""
    return {
        name: value for name, value in row.items() if _MEAN + name in row and math.isfinite(value)
    }


@dataclass(frozen=True)
class _Limits:
    """The limits of a search; see `Evolution`."""

    generations: int
    target_score: float | None = None
    max_evaluations: int | None = None
    stagnation: int | None = None


def _read_quickly(path: Path, names: frozenset[str], *, times: bool) -> Overview | None:
    """Return the overview of a run, without its history; None if the run must be read in full.

    This is the case without a checkpoint, if the checkpoint is damaged or of another experiment
    than `experiment.toml`, or if the history is too short.
    """
    try:
        text = read_regular(path / EXPERIMENT, toml.LARGEST).decode()
        stored = safe_pickle.load(path / CHECKPOINT)
        tables = toml.parse(text, EXPERIMENT)
    except (OSError, UnicodeDecodeError, GaitsimError):
        return None
    plugins = _plugins(tables)
    limits = _limits(tables)
    match stored:
        case {
            "kind": "population",
            "experiment": experiment,
            "generation": int(generation),
            "evaluations": int(evaluations),
            "stagnation": int(stagnation),
            "best_score": float(best),
            "stages": list(stages),
            "scores": {"shape": [int(individuals)]},
        } if experiment == text and best < math.inf and limits and plugins:
            reached = SearchProgress(
                evaluations, best, stagnation, None, finished=str(stored.get("finished", ""))
            )
        case _:
            return None
    seed, description = tables.get("seed", 0), tables.get("description", "")
    if type(seed) is not int or not isinstance(description, str):
        return None
    found = _read_history(path / HISTORY, generation, times=times)
    if found is None:
        return None
    seconds, terms = found
    note, tags = annotations(path)
    state, failure = run_state(
        path,
        finished=bool(stop_reason(limits, generation, reached, individuals)),
        background=bool(names) and not names.isdisjoint(status_names(path)),
    )
    return Overview(
        path,
        state,
        plugins,
        description,
        seed,
        generation=generation,
        generations=limits.generations,
        best=best if math.isfinite(best) else None,
        stage=len(stages) + 1,
        seconds=seconds,
        changed=last_modified(path),
        failure=failure,
        note=note,
        tags=tags,
        evaluations=evaluations,
        options=toml.flatten(
            {"seed": seed, **{name: one for name, one in tables.items() if type(one) is dict}}
        ),
        terms=terms,
    )


def _plugins(tables: Mapping[str, Any]) -> dict[str, str] | None:
    """Return the name of each plugin by kind; None if the experiment is incomplete."""
    found: dict[str, str] = {}
    for kind in KINDS:
        match tables.get(kind):
            case {"plugin": str(name)}:
                found[kind] = name
    return found if found.keys() >= {"organism", "fitness", "search"} else None


def _limits(tables: Mapping[str, Any]) -> _Limits | None:
    """Return the limits of the search; None if they are not numbers."""
    table = tables.get("evolution")
    names = [item.name for item in fields(_Limits)]
    given = {name: table[name] for name in names if name in table} if type(table) is dict else {}
    if type(given.get("generations")) is not int:
        return None
    return _Limits(**given) if {*map(type, given.values())} <= {int, float} else None


def _read_history(
    path: Path, generation: int, *, times: bool
) -> tuple[float, dict[str, float]] | None:
    """Return the duration of a run in seconds, or 0 without `times`, and the terms of its last row.

    Return None if the history is too short, too large, or damaged where it is read.
    """
    try:
        with open_regular(path, LARGEST) as file:
            head = file.readline(TAIL)
            (names,) = csv.reader([head.decode()])
            count = 1 + sum(part.count(b"\n") for part in iter(lambda: file.read(2**20), b""))
            if not head.startswith(_HEAD) or not 0 < generation < count:
                return None
            file.seek(max(0, file.tell() - TAIL))
            last = file.read().rsplit(b"\n", count - generation + 1)[1]
            terms = terms_of(dict(zip(names, map(float, last.split(b",")), strict=True)))
            file.seek(len(head))
            lines = islice(file, generation) if times else ()
            return sum(float(line.split(b",", _SECONDS + 1)[_SECONDS]) for line in lines), terms
    except (OSError, ValueError, IndexError, csv.Error):
        return None
