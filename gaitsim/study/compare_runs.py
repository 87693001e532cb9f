"""Compare runs: their curves, their results, the options that differ."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.choices import Axis, Quantity
from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.follow import HistoryBuffer, RunFollower
from gaitsim.study.differences import Difference, Stages, differences

QUANTITIES = get_args(Quantity)
AXES = get_args(Axis)
Values = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """What a comparison shows of one run.

    Attributes:
        label: its name in the comparison.
        path: its folder.
        history: its columns; empty before the first generation.
        stages: the first generation and the experiment of each.
        comparable: the first generation whose scores compare with those of the last one.
        problem: why it cannot be read; None where it can.
    """

    label: str
    path: Path
    history: HistoryBuffer = field(default_factory=HistoryBuffer)
    stages: Stages = ()
    comparable: int = 1
    problem: GaitsimError | None = None

    @property
    def generation(self) -> int:
        """The last finished generation; 0 before the first."""
        return len(self.history["generation"]) if self.history else 0

    @property
    def champion(self) -> int | None:
        """The generation of the best score; None where there is none."""
        scores = self.history["best"][self.comparable - 1 :] if self.history else np.empty(0)
        if not np.isfinite(scores).any():
            return None
        return self.comparable + int(np.argmax(np.where(np.isfinite(scores), scores, -np.inf)))

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

    def marks(self, by: str) -> tuple[float, ...]:
        """Return where the second and later stages begin on one of `AXES`."""
        axis = self.axis(by)
        return tuple(float(axis[first - 1]) for first, _ in self.stages[1:] if first <= len(axis))


class RunsReader:
    """Runs to compare, each read again only when it has changed.

    Args:
        paths: their folders.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        names = [path.name for path in paths]
        labels = [path.name if names.count(path.name) == 1 else str(path) for path in paths]
        self._runs = [_Reader(label, path) for label, path in zip(labels, paths, strict=True)]

    def read(self) -> tuple[ComparedRun, ...]:
        """Return the runs as they are now; one that cannot be read has its problem."""
        return tuple(run.read() for run in self._runs)


class _Reader:
    """One of the runs, and what was read of it."""

    def __init__(self, label: str, path: Path) -> None:
        self._latest = ComparedRun(label, path)
        self._follower = RunFollower(path)
        self._history = HistoryBuffer()

    def read(self) -> ComparedRun:
        run = self._follower.poll()
        if run is not None:
            label, path = self._latest.label, self._latest.path
            try:
                self._history.extend(self._follower.read_rows(run))
                stages = run.stages
                found = tuple((stage.first, stage.outline) for stage in stages)
                first = run.comparable if stages else 1
                found = found or ((1, run.outline),)
                self._latest = ComparedRun(label, path, self._history, found, first)
            except GaitsimError as error:
                self._latest = ComparedRun(label, path, problem=error)
            except OSError as error:
                problem = RunError(f"cannot read {path}: {error.strerror or error}")
                self._latest = ComparedRun(label, path, problem=problem)
        return self._latest


def comparison_table(runs: Sequence[ComparedRun]) -> tuple[Difference, ...]:
    """Return the rows of a table: the results of the runs, then the options that differ."""
    facts: dict[str, Callable[[ComparedRun], str]] = {
        "generations": lambda one: f"{one.generation:,}",
        "best score": _best,
        "found in generation": lambda one: f"{one.champion:,}" if one.champion else "–",
        "evaluations": lambda one: f"{int(one.history['evaluations'][-1]):,}",
        "seconds": lambda one: f"{float(one.history['seconds'].sum()):,.1f}",
    }
    results = [
        Difference(name, tuple(text(one) if one.history else "–" for one in runs))
        for name, text in facts.items()
    ]
    return (*results, *differing_options(runs))


def differing_options(runs: Sequence[ComparedRun]) -> tuple[Difference, ...]:
    """Return the options in which runs differ."""
    return differences([one.stages for one in runs])


def _best(run: ComparedRun) -> str:
    if run.champion is None:
        return "–"
    return f"{run.history['best'][run.champion - 1]:z.4f}".replace("-", "−")
