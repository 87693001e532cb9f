"""Compare runs: their curves, their results and the options that differ, with values by stage."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.choices import Axis, Quantity
from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import ExperimentOutline
from gaitsim.registry.options import PLUGIN
from gaitsim.storage.files.history import best_generation
from gaitsim.storage.growing import HistoryBuffer, RunFollower
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import SCORING
from gaitsim.toml import brief

Stages = Sequence[tuple[int, ExperimentOutline]]
"""The stages of a run: the first generation of each, and its experiment."""

ABSENT = "–"
NAMED = 3  # options that a warning names


@dataclass(frozen=True)
class Difference:
    """An option that differs between runs, or changed during a run.

    Attributes:
        key: key for `--set`, such as `mutation.rate`.
        values: value in each run, as text; `ABSENT` if a run does not have the option. A value
            that changed during the run is followed by the later values, each with its first
            generation.
    """

    key: str
    values: tuple[str, ...]


def differences(runs: Sequence[Stages]) -> tuple[Difference, ...]:
    """Return the options in which runs differ, in the order of their files.

    Args:
        runs: stages of each run in order; () for a run that cannot be read.
    """
    values_of = [[(first, outline.options()) for first, outline in stages] for stages in runs]
    keys = dict.fromkeys(key for stages in values_of for _, values in stages for key in values)
    found = []
    for key in keys:
        each = {_text(values.get(key)) for stages in values_of for _, values in stages if values}
        if len(each) > 1:
            found.append(
                Difference(key, tuple(_values_by_stage(key, stages) for stages in values_of))
            )
    return tuple(found)


def scoring_warning(found: Sequence[Difference]) -> str:
    """Return a warning if options that affect scores differ, else ''."""
    keys: list[str] = []
    for section in SCORING:
        own = [one.key for one in found if one.key.startswith(f"{section}.")]
        plugin = f"{section}.{PLUGIN}"
        keys += [plugin] if plugin in own else own  # different plugins have different options
    if not keys:
        return ""
    body, *others = SCORING
    scored = tuple(f"{section}." for section in others)
    certain = any(key == f"{body}.{PLUGIN}" or key.startswith(scored) for key in keys)
    named = " and ".join(keys) if len(keys) <= 2 else ", ".join(keys[:NAMED])
    more = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    verb = "are not" if certain else "may not be"
    return f"The scores {verb} comparable: {named}{more} differ{'s' * (len(keys) == 1)}."


def _values_by_stage(key: str, stages: Sequence[tuple[int, Mapping[str, Any]]]) -> str:
    """Return the values of an option over the stages, such as '0.1, from 151: 0.2'."""
    texts: list[str] = []
    last = ""
    for first, values in stages:
        text = _text(values.get(key))
        if not texts:
            texts.append(text)
        elif text != last:
            texts.append(f"from {first}: {text}")
        last = text
    return ", ".join(texts) or ABSENT


def _text(value: Any) -> str:
    return ABSENT if value is None else brief(value)


QUANTITIES = get_args(Quantity)
AXES = get_args(Axis)
Values = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """A run in a comparison.

    Attributes:
        label: name of the run in the comparison.
        path: folder of the run.
        history: columns of the history; empty before the first generation.
        stages: first generation and experiment of each stage.
        first_comparable: first generation whose scores are comparable with the last one's.
        problem: reason why the run cannot be read; None if it can.
    """

    label: str
    path: Path
    history: HistoryBuffer = field(default_factory=HistoryBuffer)
    stages: Stages = ()
    first_comparable: int = 1
    problem: GaitsimError | None = None

    @property
    def generation(self) -> int:
        """Number of the last finished generation; 0 before the first."""
        return len(self.history["generation"]) if self.history else 0

    @property
    def champion(self) -> int | None:
        """Generation of the best score; None without a finite score."""
        return (
            best_generation(self.history["best"], self.first_comparable) if self.history else None
        )

    def best_within(self, evaluations: float) -> float:
        """Return the best comparable score within a number of evaluations, or −inf."""
        if not self.history:
            return -np.inf
        scores = self.history["best"][self.first_comparable - 1 :]
        spent = self.history["evaluations"][self.first_comparable - 1 :]
        found = scores[(spent <= evaluations) & np.isfinite(scores)]
        return float(found.max(initial=-np.inf))

    def to_dict(self) -> dict[str, object]:
        """Return a summary of the run for JSON."""
        champion = self.champion
        return {
            "run": str(self.path),
            "generations": self.generation,
            "score": self.history["best"][champion - 1].item() if champion else None,
            "generation": champion,
            "evaluations": int(self.history["evaluations"][-1]) if self.history else 0,
            "seconds": float(self.history["seconds"].sum()) if self.history else 0.0,
        }

    def axis(self, by: str) -> Values:
        """Return the values of one of `AXES`, (generations,)."""
        values = self.history[by]
        return np.cumsum(values) if by == "seconds" else values

    @property
    def stage_starts(self) -> tuple[int, ...]:
        """Indices in the columns of the history at which the second and later stages begin."""
        return tuple(first - 1 for first, _ in self.stages[1:] if first <= self.generation)

    def stage_marks(self, by: str) -> tuple[float, ...]:
        """Return the values on one of `AXES` at which the second and later stages begin."""
        return tuple(self.axis(by)[list(self.stage_starts)].tolist())


class RunsReader:
    """Read runs to compare, and reread a run only when it has changed."""

    def __init__(self, paths: Sequence[Path]) -> None:
        names = [path.name for path in paths]
        self._followed = [(RunFollower(path), HistoryBuffer()) for path in paths]
        self._latest = [
            ComparedRun(path.name if names.count(path.name) == 1 else str(path), path)
            for path in paths
        ]

    def read(self) -> tuple[ComparedRun, ...]:
        """Return the current state of the runs; an unreadable run has a `problem`."""
        for place, (follower, history) in enumerate(self._followed):
            run = follower.poll()
            if run is not None:
                self._latest[place] = _read(self._latest[place].label, run, follower, history)
        return tuple(self._latest)


def _read(
    label: str, run: RunSnapshot, follower: RunFollower, history: HistoryBuffer
) -> ComparedRun:
    """Return a changed run; `history` is kept while the run is temporarily unreadable."""
    try:
        history.extend(follower.read_rows(run))
        stages = tuple((stage.first, stage.outline) for stage in run.stages)
        first = run.first_comparable if stages else 1
        return ComparedRun(label, follower.path, history, stages or ((1, run.outline),), first)
    except GaitsimError as error:
        problem = error
    except OSError as error:
        problem = RunError(f"cannot read {follower.path}: {error.strerror or error}")
    return ComparedRun(label, follower.path, problem=problem)


def least_evaluations(runs: Sequence[ComparedRun]) -> int:
    """Return the number of evaluations of the shortest run with a history; 0 without any."""
    return min((int(one.history["evaluations"][-1]) for one in runs if one.history), default=0)


def fair_axis(runs: Sequence[ComparedRun]) -> Axis:
    """Return 'evaluations' if the sizes of the runs' generations differ, else 'generation'."""
    columns = [one.history["evaluations"] for one in runs if one.history]
    shared = min(map(len, columns), default=0)
    same = all(np.array_equal(one[:shared], columns[0][:shared]) for one in columns)
    return "generation" if same else "evaluations"


def comparison_table(runs: Sequence[ComparedRun]) -> tuple[Difference, ...]:
    """Return the rows of a table: results of the runs, then the options that differ."""
    facts: dict[str, Callable[[ComparedRun], str]] = {
        "generations": lambda one: f"{one.generation:,}",
        "best score": lambda one: _score(one.best_within(np.inf)),
        "found in generation": lambda one: f"{one.champion:,}" if one.champion else "–",
        "evaluations": lambda one: f"{int(one.history['evaluations'][-1]):,}",
        "seconds": lambda one: f"{float(one.history['seconds'].sum()):,.1f}",
    }
    equal = least_evaluations(runs)
    if any(one.history and one.history["evaluations"][-1] > equal for one in runs):
        facts[f"best of {equal:,} evaluations"] = lambda one: _score(one.best_within(equal))
    results = [
        Difference(name, tuple(text(one) if one.history else "–" for one in runs))
        for name, text in facts.items()
    ]
    return (*results, *differing_options(runs))


def differing_options(runs: Sequence[ComparedRun]) -> tuple[Difference, ...]:
    """Return the options that differ between runs, or changed during one."""
    return differences([one.stages for one in runs])


def warning(runs: Sequence[ComparedRun]) -> str:
    """Return a warning if the scores of runs or of a run's stages are not comparable, else ''."""
    return scoring_warning(differing_options(runs))


def quantity_label(quantity: str) -> str:
    """Return the label of one of `QUANTITIES`, such as 'best score'."""
    return quantity if quantity == "diversity" else f"{quantity} score"


def _score(value: float) -> str:
    return f"{value:z.4f}".replace("-", "−") if np.isfinite(value) else "–"
