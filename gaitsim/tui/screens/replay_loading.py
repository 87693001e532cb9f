"""Individuals of a run for the replay: how they are numbered, read and simulated."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.search import Members
from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait.changed import with_damage
from gaitsim.individual import Individual, Measurement, Member, Numbered, Which, mark_of
from gaitsim.render.series import Series
from gaitsim.storage.growing import RunFollower
from gaitsim.storage.snapshot import RunSnapshot

PATIENCE = 2.0  # minimum seconds between two reads of an evolving run


@dataclass(frozen=True, eq=False)
class ReplayView:
    """The best of a generation, or a member, ready to be shown.

    Attributes:
        individual: individual with a computed skeleton.
        measurements: measures of its motion; {} if the body cannot compute them.
        last: last generation of the run so far.
        champion: generation of the champion; None if all individuals failed.
        stage: number of the individual's stage, and number of stages.
        history: history of the run by column.
        members: front or archive of the run; None if its search keeps neither.
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
    def which(self) -> int | Member | Numbered:
        """The individual's generation, member, or number in its generation."""
        return self.individual.member or self.generation

    @property
    def best_member(self) -> Member | None:
        """The member with the best score; None without members."""
        if self.members is None or not len(self.members.scores):
            return None
        return Member(int(np.argmax(self.members.scores)) + 1)

    @property
    def best(self) -> int | Member | None:
        """The individual that a star marks: the best member for members, else the champion."""
        return self.best_member if isinstance(self.individual.member, Member) else self.champion


class Loader:
    """Simulates individuals of a run and re-reads its files only when they have changed.

    A step therefore costs as much after 20,000 generations as after 1,000.

    Args:
        path: folder of the run.
        clock: function that returns the time in seconds.
        damage: damage of the body, in the syntax of `--damage`.
    """

    def __init__(
        self,
        path: Path,
        clock: Callable[[], float] = time.monotonic,
        damage: Sequence[str] = (),
    ) -> None:
        self._path, self._damage, self._clock = path, damage, clock
        self._forget()

    def _forget(self) -> None:
        self._run: RunSnapshot | None = None
        self._follower, self._read = RunFollower(self._path), 0.0

    def load(self, which: Which) -> ReplayView:
        """Simulate the best of a generation, the champion, or a member."""
        try:
            run = self._snapshot(which if isinstance(which, int) else 1)
            return load_individual(run, which, self._damage)
        except OSError as error:
            self._forget()
            raise RunError(f"cannot read {self._path}: {error.strerror or error}") from None
        except GaitsimError:
            self._forget()
            raise

    def _snapshot(self, generation: int) -> RunSnapshot:
        """Return the run as last read, or re-read it if it has changed."""
        known, now = self._run, self._clock()
        recent = now - self._read < PATIENCE and self._path.exists()
        if known is None or generation > known.generation or not recent:
            known = self._run = self._follower.poll() or known
            self._read = now
        assert known is not None  # the first poll reads the run
        return known


def load_individual(run: RunSnapshot, which: Which, damage: Sequence[str] = ()) -> ReplayView:
    """Simulate an individual of a run, with damage to its body if given."""
    found = run.individual(which)
    if damage:
        found = with_damage(found, damage)
    _ = found.skeleton  # computed here because it is slow
    return ReplayView(
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


def describe(which: Which) -> str:
    """Name an individual of a run."""
    if which is None:
        return "the champion"
    return f"generation {which}" if isinstance(which, int) else str(which)


def options_of(which: Which) -> list[object]:
    """Return the command-line options that select an individual of a run."""
    if which is None:
        return []
    mark = mark_of(which)
    return ["--member" if mark.startswith("#") else "--generation", mark[1:]]


def number_of(which: int | Member | Numbered) -> int:
    """Return the number of a member, or of a generation."""
    if isinstance(which, Numbered):
        return which.generation
    return which if isinstance(which, int) else which.number


def with_number(which: Which, number: int) -> int | Member:
    """Return member `number` if `which` is a member, else generation `number`."""
    return Member(number) if isinstance(which, Member) else number


def last_of(shown: ReplayView, which: Which) -> int:
    """Return the number of members if `which` is one, else the last generation."""
    if isinstance(which, Member):
        return len(shown.members.scores) if shown.members else 1
    return shown.last


def kind_of(which: Which) -> str:
    """Return the noun for an individual's number, such as 'member'."""
    return "member" if isinstance(which, Member) else "generation"


def parse_which(text: str, which: Which, shown: ReplayView) -> int | Member:
    """Read the number of an existing generation or member, of the kind of `which`."""
    return with_number(which, parse_number(text, kind_of(which), last_of(shown, which)))


def parse_number(text: str, kind: str, last: int) -> int:
    """Read a number from 1 to `last` of a kind, such as 'member'."""
    digits = text.replace(",", "").strip()
    if digits.isdecimal() and len(digits) < 10 and 1 <= int(digits) <= last:
        return int(digits)
    raise GaitsimError(f"there is no {kind} {text}", allowed=f"1 to {last:,}")


def curve_of(shown: ReplayView) -> tuple[str, Series, float]:
    """Return the label of the x axis, a curve, and the position of the individual on it.

    The curve is the best score of each generation. For a member of a front, it is the second
    objective against the first; for a member of an archive, the scores of all members.
    """
    member, members = shown.individual.member, shown.members
    if not isinstance(member, Member) or members is None:
        best = Series("best score", shown.history["generation"], shown.history["best"])
        return "generation", best, shown.generation
    if members.cells is None:  # a front, sorted by its first objective
        (across, x), (up, y), *_ = members.values.items()
    else:
        across, x = "member", np.arange(1.0, len(members.scores) + 1)
        up, y = "score", members.scores
    return across, Series(up, x, y), float(x[member.number - 1])
