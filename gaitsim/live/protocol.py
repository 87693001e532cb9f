"""What passes between the process that evolves and the one that steers it."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, error_from_dict
from gaitsim.experiment import Overrides, Typed

State = Literal["preparing", "running", "paused", "finished", "stopped", "failed", "elsewhere"]
"""Of a run; `elsewhere` while a process that is not steered from here writes it."""

ENDED: tuple[State, ...] = ("finished", "stopped", "failed")
PLACE = ("generation", "generations", "stage", "scored_from", "evaluations")
"""What says how far a run is."""

Verb = Literal["pause", "go", "step", "stop", "set"]
Kind = Literal["best", "kept", "stage", "warning"]


@dataclass(frozen=True)
class Command:
    """What whoever steers wants.

    Attributes:
        do: what.
        overrides: of `set`, values of options by key.
    """

    do: Verb
    overrides: Overrides = field(default_factory=dict)


@dataclass(frozen=True)
class Individual:
    """One of the best of a generation: its score, and the terms that it is the sum of."""

    score: float
    terms: Mapping[str, float]


@dataclass(frozen=True)
class Best:
    """The best individual so far, of those whose scores can be compared.

    Attributes:
        generation: in which it was found.
        score: its score.
        genome: (genes,).
    """

    generation: int
    score: float
    genome: tuple[float, ...]


@dataclass(frozen=True)
class Event:
    """Something that happened in a generation.

    Attributes:
        generation: after which it is known; of a stage, its first one.
        kind: `best` a better best score, `kept` a champion's file, a `stage`, or a `warning`.
        text: for people.
    """

    generation: int
    kind: Kind
    text: str


@dataclass(frozen=True, eq=False)
class Snapshot:
    """How a run stands, and what is new since the snapshot before.

    Attributes: as the package's docstring has them; `rows` are columns, (generations,) each.
    """

    state: State
    reason: str = ""
    generation: int = 0
    generations: int = 0
    stage: int = 1
    scored_from: int = 1
    evaluations: int = 0
    evaluations_per_second: float = 0.0
    generations_per_second: float = 0.0
    rows: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    top: tuple[Individual, ...] = ()
    islands: tuple[float, ...] = ()
    champion: Best | None = None
    events: tuple[Event, ...] = ()
    error: GaitsimError | None = None

    @property
    def ended(self) -> bool:
        """Whether no other snapshot follows."""
        return self.state in ENDED

    @property
    def seconds_left(self) -> float | None:
        """Until the planned generations are done, at the present speed; None where it rests."""
        speed = self.generations_per_second
        return max(self.generations - self.generation, 0) / speed if speed > 0 else None


def merged(first: Snapshot, then: Snapshot) -> Snapshot:
    """Two snapshots as one, for who is too slow for both: nothing new is lost."""
    return replace(
        then,
        rows=joined(first.rows, then.rows),
        events=(*first.events, *then.events),
        error=then.error or first.error,
    )


def joined(
    first: Mapping[str, NDArray[np.float64]], then: Mapping[str, NDArray[np.float64]]
) -> Mapping[str, NDArray[np.float64]]:
    """Rows after rows; what either has no column for is NaN."""
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


def write_command(command: Command) -> bytes:
    """A command as a line."""
    parts: dict[str, dict[str, Any]] = {}
    for key, value in command.overrides.items():
        parts.setdefault("typed" if isinstance(value, Typed) else "values", {})[key] = value
    return _line({"do": command.do, **parts})


def read_command(line: bytes) -> Command | None:
    """A line as a command; None where it is none."""
    try:
        data = json.loads(line)
        verb, typed = data["do"], data.get("typed", {}).items()
        overrides = data.get("values", {}) | {key: Typed(text) for key, text in typed}
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
    return Command(verb, overrides) if verb in get_args(Verb) else None


def write_snapshot(values: Mapping[str, Any]) -> bytes:
    """The values of a snapshot as a line; see the package's docstring for its keys."""
    return _line({name: _plain(value) for name, value in values.items()})


def read_snapshot(line: bytes, before: Snapshot) -> Snapshot:
    """A line as a snapshot; what it does not tell anew is as it was `before`.

    Raises:
        ValueError: it is none.
    """
    try:
        data = json.loads(line)
        if not data.get("generations", True):  # the run is not open yet: it tells of none
            data = {name: value for name, value in data.items() if name not in PLACE}
        champion = data.pop("champion", None)
        return replace(
            before,
            **{
                "reason": "",
                **data,
                "rows": {name: _numbers(values) for name, values in data.get("rows", {}).items()},
                "top": (
                    tuple(Individual(_number(one["score"]), _terms(one)) for one in data["top"])
                    if "top" in data
                    else before.top
                ),
                "islands": tuple(map(_number, data.get("islands", before.islands))),
                "champion": (
                    Best(champion["generation"], champion["score"], tuple(champion["genome"]))
                    if champion
                    else before.champion
                ),
                "events": tuple(Event(**event) for event in data.get("events", ())),
                "error": error_from_dict(data["error"]) if "error" in data else None,
            },
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no snapshot: {error}") from error


def _terms(individual: Mapping[str, Any]) -> dict[str, float]:
    return {name: _number(value) for name, value in individual["terms"].items()}


def _numbers(values: Sequence[float | None]) -> NDArray[np.float64]:
    return np.array([math.nan if value is None else value for value in values], np.float64)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _plain(value: Any) -> Any:
    """The same in plain values, null for what JSON has no number for."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _line(values: Mapping[str, Any]) -> bytes:
    return json.dumps(values, allow_nan=False, separators=(",", ":")).encode() + b"\n"
