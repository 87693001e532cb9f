"""Overviews of runs, and a list of them that is quick to read.

This module imports nothing heavy, so that `gaitsim runs` starts quickly.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from gaitsim import toml
from gaitsim.errors import GaitsimError
from gaitsim.opening import open_regular, read_regular
from gaitsim.registry import KINDS
from gaitsim.stopping import SearchProgress, stop_reason
from gaitsim.storage.background import (
    background_process,
    last_failure,
    runtime_names,
    status_names,
)
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.folder import CHECKPOINT, EXPERIMENT, HISTORY, list_runs
from gaitsim.storage.lock import is_locked

LARGEST = 2**30  # bytes of a history that is read

State = Literal[
    "running",
    "queued",
    "paused",
    "stopped",
    "failed",
    "finished",
    "older format",
    "newer format",
    "damaged",
]


@dataclass(frozen=True)
class Overview:
    """An overview of a run.

    Attributes:
        path: folder of the run.
        state: running (a process is evolving it), queued or paused (a background process is
            waiting), stopped (it can be resumed), failed (it can be resumed, but its background
            process failed), finished (a stop condition holds), older or newer format (written by
            another version of gaitsim), or damaged.
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
    """

    path: Path
    state: State
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

    @property
    def name(self) -> str:
        """The name of the run's folder."""
        return self.path.name

    @property
    def evolves(self) -> bool:
        """Whether a process is evolving the run, or waiting to."""
        return self.state in ("running", "paused", "queued")


def list_overviews(root: Path, read_in_full: Callable[[Path], Overview | None]) -> list[Overview]:
    """Return the runs in a folder, oldest first, in a form for lists.

    Description, seed, seconds, changed, curve and note may be left out. Of a run with an intact
    checkpoint, neither the arrays nor the values in the history are checked. This takes a fifth of
    the time of `growing.overview`, and saves the imports of that, 0.25 s.

    Args:
        root: path of the folder.
        read_in_full: function that reads another run, which is `growing.overview`.
    """
    names = runtime_names()
    found = (_read_quickly(path, names) or read_in_full(path) for path in list_runs(root))
    return [run for run in found if run is not None]


def run_state(run: Path, *, finished: bool, background: bool) -> tuple[State, GaitsimError | None]:
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


@dataclass(frozen=True)
class _Limits:
    """The limits of a search; see `Evolution`."""

    generations: int
    target_score: float | None = None
    max_evaluations: int | None = None
    stagnation: int | None = None


def _read_quickly(path: Path, names: frozenset[str]) -> Overview | None:
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
    if not 0 < generation < _count_lines(path / HISTORY, generation + 1):
        return None
    state, failure = run_state(
        path,
        finished=bool(stop_reason(limits, generation, reached, individuals)),
        background=bool(names) and not names.isdisjoint(status_names(path)),
    )
    return Overview(
        path,
        state,
        plugins,
        generation=generation,
        generations=limits.generations,
        best=best if math.isfinite(best) else None,
        stage=len(stages) + 1,
        failure=failure,
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


def _count_lines(path: Path, most: int) -> int:
    """Return the number of whole lines of a file, at most about `most`; 0 if it is unreadable."""
    count = 0
    try:
        with open_regular(path, LARGEST) as file:
            while count < most and (part := file.read(2**20)):
                count += part.count(b"\n")
    except OSError:
        return 0
    return count
