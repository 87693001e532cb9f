"""Read and move the best of a generation, or a member, for the replay."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.search import Members
from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait.damaged import with_damage
from gaitsim.individual import Individual, Measurement, Member, Which
from gaitsim.runs.files.folder import CHECKPOINT
from gaitsim.runs.snapshot import RunSnapshot

PATIENCE = 2.0  # seconds for which a run that grows is not read again


@dataclass(frozen=True, eq=False)
class Shown:
    """One generation's best, or a member, ready to be shown.

    Attributes:
        individual: whose skeleton is worked out.
        measurements: of its motion; {} where the body fails at that, as it still is shown.
        last: the run's last generation so far.
        champion: the generation of the best of all; None where all failed.
        stage: the number of its stage, and how many there are.
        history: of the run, by column.
        members: the front or archive of the run; None where its search keeps none.
    """

    individual: Individual
    measurements: Mapping[str, Measurement]
    last: int
    champion: int | None
    stage: tuple[int, int]
    history: Mapping[str, NDArray[np.float64]]
    members: Members | None = None

    @property
    def generation(self) -> int:
        """The generation of the individual."""
        return self.individual.generation

    @property
    def which(self) -> int | Member:
        """The individual as the run names it."""
        return self.individual.member or self.generation

    @property
    def best_member(self) -> Member | None:
        """The member with the best score; None where there are none."""
        if self.members is None or not len(self.members.scores):
            return None
        return Member(int(np.argmax(self.members.scores)) + 1)

    @property
    def best(self) -> int | Member | None:
        """What a star marks: the best member where one is shown, else the champion."""
        return self.champion if self.individual.member is None else self.best_member


class Loader:
    """Moves individuals of a run, whose files are read again only when they changed.

    So a step costs as much after 20,000 generations as after 1,000.

    Args:
        path: the run's folder.
        clock: seconds that pass.
        damage: of the body, as `--damage` takes it.
    """

    def __init__(
        self,
        path: Path,
        clock: Callable[[], float] = time.monotonic,
        damage: Sequence[str] = (),
    ) -> None:
        self._path, self._damage, self._clock = path, damage, clock
        self._run: RunSnapshot | None = None
        self._state: tuple[int, ...] = ()
        self._read = 0.0

    def load(self, which: Which) -> Shown:
        """Move the best of a generation, or of all, or a member.

        Raises:
            GaitsimError: there is none, the run is damaged, or the body cannot be drawn; an
                OSError is raised as one.
        """
        try:
            run = self._snapshot(which if isinstance(which, int) else 1)
            return shown_of(run, which, self._damage)
        except OSError as error:
            self._run = None
            raise RunError(f"cannot read {self._path}: {error.strerror or error}") from None
        except GaitsimError:
            self._run = None
            raise

    def _snapshot(self, generation: int) -> RunSnapshot:
        """Return the run as it was read, or read it if it changed."""
        try:
            found = (self._path / CHECKPOINT).stat()
            state: tuple[int, ...] = found.st_ino, found.st_size, found.st_mtime_ns
        except FileNotFoundError:
            state = ()
        known, now = self._run, self._clock()
        fresh = known is not None and (
            state == self._state
            or (state and now - self._read < PATIENCE and generation <= known.generation)
        )
        if known is None or not fresh:
            known = self._run = RunSnapshot(self._path)
            self._state, self._read = state, now
        return known


def shown_of(run: RunSnapshot, which: Which, damage: Sequence[str] = ()) -> Shown:
    """Move an individual of a run as it was read, on its damaged body if there is damage.

    Raises:
        GaitsimError: there is none, the run is damaged, or the body cannot be drawn.
        OSError: a file cannot be read.
    """
    found = run.individual(which)
    if damage:
        found = with_damage(found, damage)
    _ = found.skeleton  # here, as it takes long
    return Shown(
        individual=found,
        measurements=_measured(found),
        last=run.generation,
        champion=run.best_generation,
        stage=(run.stage_at(found.generation).number, len(run.stages)),
        history=run.history,
        members=run.members,
    )


def _measured(individual: Individual) -> Mapping[str, Measurement]:
    try:
        return individual.measurements
    except GaitsimError:
        return {}
