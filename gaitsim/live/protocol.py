"""Messages between the process of a run and its clients."""

import json
import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, error_from_dict
from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment, ExperimentOutline, Overrides, Typed
from gaitsim.storage.background import RunState
from gaitsim.storage.files.history import island_bests
from gaitsim.storage.growing import Rows

ENDED: tuple[RunState, ...] = ("finished", "stopped", "failed")
PROGRESS_KEYS = ("generation", "generations", "stage", "scored_from", "evaluations")
"""Keys of a snapshot about the progress of the run."""

Verb = Literal["pause", "go", "step", "stop", "set"]
EventKind = Literal["best", "kept", "stage", "warning"]


@dataclass(frozen=True)
class RunCommand:
    """A command of the controlling process.

    Attributes:
        do: verb of the command.
        overrides: values of options by key, for `set`.
    """

    do: Verb
    overrides: Overrides = field(default_factory=dict)


@dataclass(frozen=True)
class Best:
    """One of the best individuals, of a generation or so far.

    Attributes:
        generation: generation in which it was found.
        score: score of the individual.
        genome: genome, (genes,), of the best individual so far; () for one of a generation.
        terms: terms of the score of one of a generation; {} for the best individual so far.
    """

    generation: int
    score: float
    genome: tuple[float, ...] = ()
    terms: Mapping[str, float] = field(default_factory=dict)


def top_individuals(generation: Generation, count: int = 5) -> tuple[Best, ...]:
    """Return the best individuals of a generation, best first."""
    scores, evaluation = generation.scores, generation.evaluation
    best = np.argsort(-scores, kind="stable")[:count].tolist()
    return tuple(
        Best(generation.number, float(scores[index]), terms=evaluation.terms_of(index))
        for index in best
    )


@dataclass(frozen=True)
class Event:
    """An event in a generation.

    Attributes:
        generation: generation of the event; for a stage, its first one.
        kind: `best` (new best score), `kept` (saved champion), `stage` or `warning`.
        text: description for people.
    """

    generation: int
    kind: EventKind
    text: str


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The state of a run, and the changes since the last snapshot.

    The package's docstring lists the attributes; each column of `rows` is (generations,).
    """

    state: RunState
    reason: str = ""
    generation: int = 0
    generations: int = 0
    stage: int = 1
    scored_from: int = 1
    evaluations: int = 0
    evaluations_per_second: float = 0.0
    generations_per_second: float = 0.0
    scored: float = 0.0
    rows: Rows = field(default_factory=dict)
    top: tuple[Best, ...] = ()
    islands: tuple[float, ...] = ()
    champion: Best | None = None
    events: tuple[Event, ...] = ()
    error: GaitsimError | None = None

    @property
    def ended(self) -> bool:
        """Whether this is the last snapshot."""
        return self.state in ENDED

    @property
    def seconds_left(self) -> float | None:
        """Seconds until the planned generations are done at the current speed; None while idle."""
        speed = self.generations_per_second
        return max(self.generations - self.generation, 0) / speed if speed > 0 else None


def snapshot_of(
    generation: Generation | None, experiment: Experiment | ExperimentOutline, **more: Any
) -> Snapshot:
    """Return the snapshot of a generation, without its genomes; an empty one before the first."""
    generations, islands = experiment.evolution.generations, experiment.islands.number
    if generation is None:
        return Snapshot("running", generations=generations, **more)
    progress, number = generation.progress, generation.number
    bests = tuple(island_bests(generation, islands).tolist()) if islands > 1 else ()
    found = number - progress.stagnation
    return Snapshot(
        "finished" if generation.stop else "running",
        reason=generation.stop,
        generation=number,
        generations=generations,
        stage=progress.stage,
        evaluations=progress.evaluations,
        top=top_individuals(generation),
        islands=bests,
        # A re-evaluated generation has no champion yet.
        champion=Best(found, progress.best_score) if progress.stagnation >= 0 else None,
        **more,
    )


def merge(first: Snapshot, then: Snapshot) -> Snapshot:
    """Merge two snapshots for a slow reader, keeping all rows and events."""
    return replace(
        then,
        rows=concatenate(first.rows, then.rows),
        events=(*first.events, *then.events),
        error=then.error or first.error,
    )


def concatenate(first: Rows, then: Rows) -> Rows:
    """Concatenate rows; fill missing columns with NaN."""
    if not first or not then:
        return then or first
    counts = [len(next(iter(part.values()))) for part in (first, then)]
    return {
        name: np.concatenate(
            [
                part.get(name, np.full(count, np.nan))
                for part, count in zip((first, then), counts, strict=True)
            ]
        )
        for name in dict.fromkeys([*first, *then])
    }


def write_command(command: RunCommand) -> bytes:
    """Return a command as a line."""
    parts: dict[str, dict[str, Any]] = {}
    for key, value in command.overrides.items():
        parts.setdefault("typed" if isinstance(value, Typed) else "values", {})[key] = value
    return _line({"do": command.do, **parts})


def read_command(line: bytes) -> RunCommand | None:
    """Parse a line; return None if it is not a command."""
    try:
        data = json.loads(line)
        verb, typed = data["do"], data.get("typed", {}).items()
        overrides = data.get("values", {}) | {key: Typed(text) for key, text in typed}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return RunCommand(verb, overrides) if verb in get_args(Verb) else None


def write_snapshot(values: Mapping[str, Any]) -> bytes:
    """Return the values of a snapshot as a line; the package's docstring lists the keys."""
    return _line({name: _plain(value) for name, value in values.items()})


def read_snapshot(line: bytes, before: Snapshot) -> Snapshot:
    """Parse a line; missing keys except rows, events and errors keep the values of `before`."""
    try:
        data = json.loads(line)
        if not data.get("generations", True):  # the run is not open yet
            data = {name: value for name, value in data.items() if name not in PROGRESS_KEYS}
        champion = data.pop("champion", None)
        return replace(
            before,
            **{
                "reason": "",
                **data,
                "rows": {name: _numbers(values) for name, values in data.get("rows", {}).items()},
                # Processes of earlier versions do not send the generation.
                "top": tuple(_best({"generation": 0, **one}) for one in data["top"])
                if "top" in data
                else before.top,
                "islands": tuple(map(_number, data.get("islands", before.islands))),
                "champion": _best(champion) if champion else before.champion,
                "events": tuple(Event(**event) for event in data.get("events", ())),
                "error": error_from_dict(data["error"]) if "error" in data else None,
            },
        )
    except (KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"not a snapshot: {error}") from error


def _best(data: Mapping[str, Any]) -> Best:
    terms = {name: _number(value) for name, value in data.get("terms", {}).items()}
    return Best(data["generation"], _number(data["score"]), tuple(data.get("genome", ())), terms)


def _numbers(values: Sequence[float | None]) -> NDArray[np.float64]:
    return np.array([math.nan if value is None else value for value in values], np.float64)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _plain(value: Any) -> Any:
    """Return JSON-compatible values, with None for non-finite numbers."""
    if isinstance(value, Best | Event):
        value = {name: item for name, item in vars(value).items() if item not in ((), {})}
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _line(values: Mapping[str, Any]) -> bytes:
    return json.dumps(values, allow_nan=False, separators=(",", ":")).encode() + b"\n"


Clock = Callable[[], float]


class Speed:
    """Evaluations and generations per second, over the last few seconds."""

    def __init__(self, recent: float, clock: Clock = time.monotonic) -> None:
        self._recent, self._clock = recent, clock
        self._counts: deque[tuple[float, int, int]] = deque()

    def add(self, generation: int, evaluations: int) -> None:
        """Record the numbers of the last generation and of evaluations so far."""
        now = self._clock()
        self._counts.append((now, generation, evaluations))
        while len(self._counts) > 2 and now - self._counts[1][0] >= self._recent:
            self._counts.popleft()

    def clear(self) -> None:
        """Discard the counts, such as before a pause."""
        self._counts.clear()

    def per_second(self) -> dict[str, Any]:
        """Return both speeds by their keys in a snapshot; 0 while the search is idle."""
        evaluations = generations = 0.0
        if len(self._counts) > 1:
            (start, first, before), (end, last, after) = self._counts[0], self._counts[-1]
            passed = max(end - start, 1e-9)
            evaluations, generations = (after - before) / passed, (last - first) / passed
        return {"evaluations_per_second": evaluations, "generations_per_second": generations}
