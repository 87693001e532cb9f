"""The live screen's knowledge of a run: snapshot, history, events and champion."""

from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.live.background import evolving
from gaitsim.live.protocol import Best, Event, Snapshot, joined
from gaitsim.runs.background import last_failure
from gaitsim.runs.follow import HistoryBuffer, Rows
from gaitsim.runs.snapshot import RunSnapshot

EVENTS_KEPT = 200


class LiveState:
    """The latest snapshot of a run, its history and its events.

    Attributes:
        snapshot: the latest; its rows and events are in the course and the events.
        course: the history.
        events: the latest ones.
        gap: whether rows are missing, so the history must be read again.
        known: whether there has been a snapshot.
    """

    def __init__(self) -> None:
        self.snapshot = Snapshot("stopped")
        self.course = HistoryBuffer()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.gap = self.known = False
        self._early: Rows = {}  # of generations after the gap

    def take(self, snapshot: Snapshot) -> None:
        """Add a snapshot."""
        self.snapshot, self.known = snapshot, True
        # Those that the folder told already come once more if they were on their way.
        self.events.extend(one for one in snapshot.events if one not in self.events)
        if not self.course.extend(snapshot.rows):
            self._early = joined(self._early, snapshot.rows)
        self.gap = len(self.course) < snapshot.generation

    def reread(self, found: Snapshot, course: HistoryBuffer) -> None:
        """Replace the history by that of the run's folder, and the events up to its end."""
        course.extend(self._early)
        if len(course) <= len(self.course):
            return
        self.course, self._early = course, {}
        self.gap = len(course) < self.snapshot.generation
        later = [one for one in self.events if one.generation > found.generation]
        warnings = [one for one in self.events if one.kind == "warning" and one not in later]
        known = sorted([*found.events, *warnings], key=lambda event: event.generation)
        self.events = deque([*known, *later], maxlen=EVENTS_KEPT)


def explained(found: Snapshot, known: Snapshot, run: Path) -> Snapshot:
    """Return what was found of a run, with the failure of its last process, or as it was known.

    Args:
        found: of the run's folder.
        known: before.
        run: the folder.
    """
    if found.state == "elsewhere":  # perhaps in the background, to be steered in a moment
        return replace(found, state=evolving(run) or "elsewhere")
    error = last_failure(run) if found.state == "stopped" else None
    if error is not None:
        return replace(found, state="failed", error=error)
    if found.error is not None and not found.generations:  # the folder cannot be read any more
        return replace(known, state="failed", rows={}, events=(), error=found.error)
    return found


def about(run: Path) -> str:
    """Return body, fitness and seed, without loading a plugin; '' if the file is unreadable."""
    try:
        outline = RunSnapshot(run).outline
    except GaitsimError:
        return ""
    body, fitness = outline.plugins["organism"], outline.plugins["fitness"]
    return f"{body} · {fitness} · seed {outline.seed}"


def keeps_archive(run: Path) -> bool:
    """Return whether the search of a run keeps an archive; False where it cannot be loaded."""
    try:
        return RunSnapshot(run).experiment.search.keeps == "archive"
    except GaitsimError:
        return False


class ChampionMover:
    """Moves the champions of the run in the folder `run`."""

    def __init__(self, run: Path) -> None:
        self._run, self._stage = run, 0
        self._experiment: Experiment | None = None

    def move(self, champion: Best, stage: int) -> Skeleton:
        """Return the skeleton of a champion, in the experiment of a stage.

        Raises:
            GaitsimError: its body's plugin is missing, or cannot move or draw it.
        """
        if self._experiment is None or stage != self._stage:
            self._experiment = RunSnapshot(self._run).experiment_at(champion.generation)
            self._stage = stage
        experiment = self._experiment
        if not champion.genome:
            raise RunError("the champion cannot be read", remedy="see what 'gaitsim show' says")
        genome = np.array(champion.genome, dtype=experiment.space().dtype)
        return Individual(
            experiment, champion.score, {}, champion.generation, genome, self._run
        ).skeleton
