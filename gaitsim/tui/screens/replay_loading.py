"""Read and move the best of a generation, for the replay."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError
from gaitsim.individual import Individual, Measurement
from gaitsim.runs.snapshot import RunSnapshot


@dataclass(frozen=True, eq=False)
class Shown:
    """One generation's best, ready to be shown.

    Attributes:
        individual: whose skeleton is worked out.
        measurements: of its motion; {} where the body fails at that, as it still is shown.
        last: the run's last generation so far.
        champion: the generation of the best of all; None where all failed.
        stage: the number of its stage, and how many there are.
        history: of the run, by column.
    """

    individual: Individual
    measurements: Mapping[str, Measurement]
    last: int
    champion: int | None
    stage: tuple[int, int]
    history: Mapping[str, NDArray[np.float64]]

    @property
    def generation(self) -> int:
        """The generation of the individual."""
        return self.individual.generation


def load(path: Path, generation: int | None) -> Shown:
    """Move the best of a generation, or of all.

    Raises:
        GaitsimError: there is none, the run is damaged, or the body cannot be drawn; an
            OSError is raised as one.
    """
    try:
        run = RunSnapshot(path)
        found = run.individual(generation)
        _ = found.skeleton  # here, as it takes long
        history = run.history
        return Shown(
            individual=found,
            measurements=_measured(found),
            last=len(history["best"]),
            champion=run.best_generation,
            stage=(run.stage_at(found.generation).number, len(run.stages)),
            history=history,
        )
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror or error}") from None


def _measured(individual: Individual) -> Mapping[str, Measurement]:
    try:
        return individual.measurements
    except GaitsimError:
        return {}
