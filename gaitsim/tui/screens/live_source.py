"""The live screen's data of a run: snapshot, history, events and champion."""

from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.live.process import background_state
from gaitsim.live.protocol import Best, Event, Snapshot, concatenate
from gaitsim.storage.background import last_failure
from gaitsim.storage.growing import HistoryBuffer, Rows
from gaitsim.storage.snapshot import RunSnapshot

EVENTS_KEPT = 200


class LiveState:
    """The latest snapshot of a run, its history and its events.

    Attributes:
        snapshot: latest snapshot; its rows and events are added to `course` and `events`.
        course: history of the run.
        events: latest events.
        gap: whether rows are missing, so the history must be re-read.
        known: whether a snapshot has arrived.
    """

    def __init__(self) -> None:
        self.snapshot = Snapshot("stopped")
        self.course = HistoryBuffer()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.gap = self.known = False
        self._early: Rows = {}  # rows of generations after the gap

    def take(self, snapshot: Snapshot) -> None:
        """Add a snapshot."""
        self.snapshot, self.known = snapshot, True
        # Events in transit may already have been read from the folder.
        self.events.extend(one for one in snapshot.events if one not in self.events)
        if not self.course.extend(snapshot.rows):
            self._early = concatenate(self._early, snapshot.rows)
        self.gap = len(self.course) < snapshot.generation

    def reread(self, found: Snapshot, course: HistoryBuffer) -> None:
        """Replace the history, and the events up to its end, with those of the run's folder."""
        course.extend(self._early)
        if len(course) <= len(self.course):
            return
        self.course, self._early = course, {}
        self.gap = len(course) < self.snapshot.generation
        later = [one for one in self.events if one.generation > found.generation]
        warnings = [one for one in self.events if one.kind == "warning" and one not in later]
        known = sorted([*found.events, *warnings], key=lambda event: event.generation)
        self.events = deque([*known, *later], maxlen=EVENTS_KEPT)


def with_failure(found: Snapshot, known: Snapshot, run: Path) -> Snapshot:
    """Return a snapshot with the failure of the run's last process added.

    If the folder can no longer be read, the result is the known snapshot with the error.

    Args:
        found: new snapshot of the run's folder.
        known: previous snapshot.
        run: folder of the run.
    """
    if found.state == "elsewhere":  # perhaps in the background, where it can be steered
        return replace(found, state=background_state(run) or "elsewhere")
    error = last_failure(run) if found.state == "stopped" else None
    if error is not None:
        return replace(found, state="failed", error=error)
    if found.error is not None and not found.generations:  # the folder can no longer be read
        return replace(known, state="failed", rows={}, events=(), error=found.error)
    return found


def describe_run(run: Path) -> str:
    """Return the body, fitness and seed without loading plugins; '' if the file is unreadable."""
    try:
        outline = RunSnapshot(run).outline
    except GaitsimError:
        return ""
    body, fitness = outline.plugins["organism"], outline.plugins["fitness"]
    return f"body {body} · fitness {fitness} · seed {outline.seed}"


def kept_by(run: Path) -> str:
    """Return what the search of a run keeps, 'front' or 'archive'; '' if neither or unreadable."""
    try:
        return RunSnapshot(run).experiment.search.keeps
    except GaitsimError:
        return ""


class ChampionSimulator:
    """Simulates the champions of the run in the folder `run`."""

    def __init__(self, run: Path) -> None:
        self._run, self._stage = run, 0
        self._experiment: Experiment | None = None

    def simulate(self, champion: Best, stage: int) -> Skeleton:
        """Return the skeleton of a champion, with the experiment of a stage."""
        if self._experiment is None or stage != self._stage:
            run = RunSnapshot(self._run)
            # A generation that is not on disk yet belongs to the current experiment.
            saved = champion.generation <= run.generation
            self._experiment = run.experiment_at(champion.generation) if saved else run.experiment
            self._stage = stage
        experiment = self._experiment
        if not champion.genome:
            raise RunError("the champion cannot be read", remedy="run 'gaitsim show' for details")
        genome = np.array(champion.genome, dtype=experiment.space().dtype)
        return Individual(
            experiment, champion.score, {}, champion.generation, genome, self._run
        ).skeleton
