"""What the replay shows of one generation's best: read and moved in a thread."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError, RunError
from gaitsim.registry import plugin_errors
from gaitsim.runs.files.history import best_terms
from gaitsim.runs.reader import Run
from gaitsim.runs.replay import Replay, replay


@dataclass(frozen=True, eq=False)
class Shown:
    """One generation's best, ready to be shown.

    Attributes:
        generation: in which it was found.
        last: the run's last generation so far.
        champion: the generation of the best of all; None where all failed.
        score: its score.
        stage: the number of its stage, and how many there are.
        skeleton: its body over time.
        terms: of its score, by name.
        measures: of its motion: value and unit by name.
        history: of the run, by column.
        marks: generations with which stages begin.
    """

    generation: int
    last: int
    champion: int | None
    score: float
    stage: tuple[int, int]
    skeleton: Skeleton
    terms: Mapping[str, float]
    measures: Mapping[str, tuple[float, str]]
    history: Mapping[str, NDArray[np.float64]]
    marks: tuple[int, ...]


def load(path: Path, generation: int | None) -> Shown:
    """Move the best of a generation, or of all.

    Raises:
        GaitsimError: there is none, the run is damaged, or the body cannot be drawn; an
            OSError is told as one.
    """
    try:
        run = Run(path)
        found = replay(run, generation)
        history = run.history
        return Shown(
            generation=found.generation,
            last=len(history["best"]),
            champion=_champion(run),
            score=found.score,
            stage=(run.stage_at(found.generation).number, len(run.stages)),
            skeleton=found.skeleton,
            terms=best_terms(history, found.generation),
            measures=_measures(found),
            history=history,
            marks=tuple(stage.first for stage in run.stages[1:]),
        )
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror or error}") from None


def _champion(run: Run) -> int | None:
    try:
        return run.champion()[0]
    except RunError:
        return None


def _measures(found: Replay) -> dict[str, tuple[float, str]]:
    """What the body says of its motion; nothing where it fails at that, as it still is shown."""
    try:
        with plugin_errors(found.experiment.entries["organism"], "measuring the champion"):
            measures = found.experiment.organism.measures(found.motion)
            return {
                str(name): (float(measure.values[0]), str(measure.unit))
                for name, measure in measures.items()
            }
    except GaitsimError:
        return {}
