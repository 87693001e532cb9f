"""Reports of the progress of a run, at a bounded rate and without blocking the search."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.evolution import Generation
from gaitsim.experiment import OWN_WORLD
from gaitsim.live.protocol import (
    ENDED,
    Best,
    Clock,
    Event,
    EventKind,
    Speed,
    top_individuals,
    write_snapshot,
)
from gaitsim.storage.background import RunState
from gaitsim.storage.files.folder import champion_file
from gaitsim.storage.files.history import island_bests, row
from gaitsim.storage.writer import RunWriter

PERIOD = 0.05  # seconds between two lines
ROWS_KEPT = 1000  # for a slow reader; all rows are on disk
EVENTS_KEPT = 50
RECENT = 2.0  # seconds over which speeds are measured
TRANSIENT_KEYS = ("rows", "events", "error")  # keys that later clients do not receive


class Reporter:
    """A collector of a run's progress, which writes snapshots in its own thread.

    Args:
        write: function that writes a line; it may block until the reader is ready.
        on_state: function called with every state and its error, before they are written.
        period: seconds between two lines.
        clock: function that returns the time in seconds from any origin.
    """

    def __init__(
        self,
        write: Callable[[bytes], object],
        on_state: Callable[[RunState, GaitsimError | None], object] = lambda state, error: None,
        period: float = PERIOD,
        clock: Clock = time.monotonic,
    ) -> None:
        self._write, self._period = write, period
        self._on_state = on_state
        self._speed = Speed(RECENT, clock)
        self._clock, self._begun = clock, clock()  # the time at which the generation began
        self._lock = threading.Lock()
        self._values: dict[str, Any] = {
            "state": "preparing",
            "reason": "",
            "generation": 0,
            "generations": 0,
            "stage": 1,
            "scored_from": 1,
            "evaluations": 0,
            "scored": 0.0,
        }
        self._news: dict[str, Any] = {}
        self._known: dict[str, Any] = {**self._values, **self._speed.per_second()}
        self._rows: deque[dict[str, float]] = deque(maxlen=ROWS_KEPT)
        self._events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._latest: Generation | None = None
        self._islands = 1
        self._worlds = OWN_WORLD
        self._opened: set[tuple[int, str, str]] = set()
        self._wake, self._ending = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def run_opened(self, writer: RunWriter) -> None:
        """Report the progress, the planned generations, and the new stage of a run."""
        last = writer.last
        with self._lock:
            self._islands = writer.experiment.islands.number
            self._values["generations"] = writer.experiment.evolution.generations
            self._values["stage"] = writer.stage
            self._worlds = writer.experiment.worlds
            self._values["scored_from"] = _scored_from(writer)
            if last is not None:
                self._values["generation"] = last.number
                self._values["evaluations"] = last.progress.evaluations
        first = last.number + 1 if last else 1
        events: list[tuple[EventKind, str]] = (
            [("warning", writer.warning)] if writer.warning and not self._opened else []
        )
        events += [("stage", str(change)) for change in writer.changes]
        # A run reopened after a rejected change has the same events again; skip those.
        for kind, text in events:
            if (first, kind, text) not in self._opened:
                self.event(first, kind, text)
        self._opened = {(0, "opened", ""), *((first, kind, text) for kind, text in events)}

    def evolution_starts(self, generation: Generation | None, champion: Best | None) -> None:
        """Report the last generation and the champion, before evolution continues."""
        with self._lock:
            self._latest, self._begun = generation, self._clock()
            if champion is not None:
                self._news["champion"] = champion
        self._wake.set()

    def generation_finished(self, generation: Generation) -> None:
        """Report a finished generation, which is on disk half a second later at the latest."""
        number, progress = generation.number, generation.progress
        improved = progress.stagnation == 0 and math.isfinite(progress.best_score)
        values = row(generation)
        with self._lock:
            self._begun, self._values["scored"] = self._clock(), 0.0
            self._values["generation"] = number
            self._values["stage"] = progress.stage
            if self._worlds.redrawn(number):
                self._values["scored_from"] = number
            self._values["evaluations"] = progress.evaluations
            self._rows.append(values)
            self._latest = generation
            self._speed.add(number, progress.evaluations)
            if improved:
                genome = tuple(generation.genomes[generation.best].tolist())
                self._news["champion"] = Best(number, progress.best_score, genome)
        if improved:
            self.event(number, "best", f"{progress.best_score:.4f}")
        if generation.is_champion:
            self.event(number, "kept", champion_file(number))
        self._wake.set()

    def scored(self, share: float) -> None:
        """Report the share of the next generation that is scored, if the generation is long."""
        if self._clock() - self._begun > RECENT:
            with self._lock:
                self._values["scored"] = share
            self._wake.set()

    def event(self, generation: int, kind: EventKind, text: str) -> None:
        """Report an event."""
        with self._lock:
            self._events.append(Event(generation, kind, text))
        self._wake.set()

    def warning(self, text: str) -> None:
        """Report a warning about the next generation."""
        self.event(self._values["generation"], "warning", text)

    def state(self, state: RunState, reason: str = "", error: GaitsimError | None = None) -> None:
        """Report a state and an error; after a final state, wait until all is written."""
        with self._lock:  # a client that has read the state from a file is greeted with the same
            self._on_state(state, error)
            self._values["state"], self._values["reason"] = state, reason
            if error is not None:
                self._news["error"] = error.to_dict()
            if state != "running":
                self._speed.clear()
        if state in ENDED:
            self._ending.set()
        self._wake.set()
        if state in ENDED:
            self._thread.join()

    def full_snapshot(self) -> bytes:
        """Return a line with all keys but transient ones, for a client that connects later."""
        with self._lock:
            known = self._known | self._values
        return write_snapshot(known)

    def _run(self) -> None:
        while True:
            self._wake.wait()
            self._wake.clear()
            ending = self._ending.is_set()
            self._write(write_snapshot(self._collect()))
            if ending:
                return
            self._ending.wait(self._period)

    def _collect(self) -> dict[str, Any]:
        with self._lock:
            rows, self._rows = self._rows, deque(maxlen=ROWS_KEPT)
            events, self._events = self._events, deque(maxlen=EVENTS_KEPT)
            news, self._news = self._news, {}
            latest, self._latest = self._latest, None
            taken = {**self._values, **self._speed.per_second()}
        if rows:
            names = dict.fromkeys(name for values in rows for name in values)
            news["rows"] = {name: [values.get(name) for values in rows] for name in names}
        if latest is not None:
            news["top"] = top_individuals(latest)
            if self._islands > 1:
                news["islands"] = island_bests(latest, self._islands).tolist()
        if events:
            news["events"] = list(events)
        taken |= news
        kept = {name: value for name, value in taken.items() if name not in TRANSIENT_KEYS}
        with self._lock:
            self._known = self._known | kept
        return taken


def _scored_from(writer: RunWriter) -> int:
    if writer.last is None:
        return 1
    reevaluated = any(change.reevaluates for change in writer.changes)
    return writer.last.number + 1 if reevaluated else writer.run.first_comparable
