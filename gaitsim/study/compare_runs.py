"""Runs side by side: their curves, and what became of each."""

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
BY = get_args(Axis)
Values = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Course:
    """A run as it went.

    Attributes:
        label: what it is called beside the others.
        path: its folder.
        history: its columns; empty before the first generation.
        stages: the first generation and the experiment of each.
        comparable: the first generation whose scores compare with those of the last one.
        problem: why it cannot be read.
    """

    label: str
    path: Path
    history: HistoryBuffer = field(default_factory=HistoryBuffer)
    stages: Stages = ()
    comparable: int = 1
    problem: GaitsimError | None = None

    @property
    def generation(self) -> int:
        """The last one that is finished; 0 before the first."""
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
        """One of `BY` at each generation."""
        values = self.history[by]
        return np.cumsum(values) if by == "seconds" else values

    def marks(self, by: str) -> tuple[float, ...]:
        """Where stages but the first begin, on one of `BY`."""
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
        self._runs = [_Compared(label, path) for label, path in zip(labels, paths, strict=True)]

    def read(self) -> tuple[Course, ...]:
        """Return the runs as they are now; one that cannot be read has its problem."""
        return tuple(run.read() for run in self._runs)


class _Compared:
    """One of the runs, and what was read of it."""

    def __init__(self, label: str, path: Path) -> None:
        self._course = Course(label, path)
        self._follower = RunFollower(path)
        self._history = HistoryBuffer()

    def read(self) -> Course:
        run = self._follower.poll()
        if run is not None:
            label, path = self._course.label, self._course.path
            try:
                self._history.extend(self._follower.read_rows(run))
                stages = run.stages
                told = tuple((stage.first, stage.experiment) for stage in stages)
                first = run.comparable if stages else 1
                told = told or ((1, run.experiment_text),)
                self._course = Course(label, path, self._history, told, first)
            except GaitsimError as error:
                self._course = Course(label, path, problem=error)
            except OSError as error:
                problem = RunError(f"cannot read {path}: {error.strerror or error}")
                self._course = Course(label, path, problem=problem)
        return self._course


def table(courses: Sequence[Course]) -> tuple[Difference, ...]:
    """What became of each run, then the options in which they differ; a value a run."""
    facts: dict[str, Callable[[Course], str]] = {
        "generations": lambda one: f"{one.generation:,}",
        "best score": _best,
        "found in generation": lambda one: f"{one.champion:,}" if one.champion else "–",
        "evaluations": lambda one: f"{int(one.history['evaluations'][-1]):,}",
        "seconds": lambda one: f"{float(one.history['seconds'].sum()):,.1f}",
    }
    told = [
        Difference(name, tuple(say(one) if one.history else "–" for one in courses))
        for name, say in facts.items()
    ]
    return (*told, *options(courses))


def options(courses: Sequence[Course]) -> tuple[Difference, ...]:
    """The options in which runs differ; a value a run."""
    return differences([one.stages for one in courses])


def _best(course: Course) -> str:
    if course.champion is None:
        return "–"
    return f"{course.history['best'][course.champion - 1]:z.4f}".replace("-", "−")
