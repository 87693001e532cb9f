"""The progress of a run that is stopped, or written by another process, read from its folder."""

import asyncio
import time
from collections.abc import AsyncIterator, Collection, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.live.protocol import Best, Clock, Event, Snapshot, Speed, snapshot_of
from gaitsim.storage.files.checkpoint import Checkpoint
from gaitsim.storage.files.folder import champion_file, champion_generations, deleted_or_moved
from gaitsim.storage.growing import HistoryBuffer, RunFollower
from gaitsim.storage.lock import is_locked
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import RunStage, restore_generation

PERIOD = 0.25  # seconds between two reads
RECENT = 3.0  # seconds over which speeds are measured


def events_in(
    history: HistoryBuffer, stages: Sequence[RunStage], kept: Collection[int], first: int = 1
) -> list[Event]:
    """Return the new best scores, saved champions and stages of a run, in order."""
    found = [
        Event(stage.first, "stage", str(change))
        for stage in stages
        if stage.first >= first
        for change in stage.changes
    ]
    found += [Event(number, "kept", champion_file(number)) for number in kept if number >= first]
    for start, end in _comparable(stages, len(history)):
        best = history["best"][start - 1 : end]
        highest = np.maximum.accumulate(best)
        rises = np.flatnonzero(best[1:] > highest[:-1]) + 1
        if len(best) and np.isfinite(best[0]):
            rises = np.concatenate([[0], rises])
        found += [
            Event(start + int(index), "best", f"{best[index]:.4f}")
            for index in rises[np.searchsorted(rises, first - start) :]
        ]
    order = ("stage", "best", "kept", "warning")
    return sorted(found, key=lambda event: (event.generation, order.index(event.kind)))


def _comparable(stages: Sequence[RunStage], generations: int) -> list[tuple[int, int]]:
    """Return the first and last generation of each span with comparable scores."""
    starts: set[int] = set()
    for stage in stages:
        if stage.number == 1 or stage.reevaluated:
            starts.add(stage.first)
        starts.update(stage.outline.worlds.redraws(stage.first, min(stage.last, generations)))
    first = sorted(starts)
    return list(zip(first, [*(start - 1 for start in first[1:]), generations], strict=True))


class RunWatcher:
    """Snapshots of a growing run folder; only the champion requires plugins.

    An asynchronous iterator of snapshots, the first with all rows and events. It ends with the
    first snapshot of a run that no process writes.
    """

    def __init__(
        self,
        path: Path,
        period: float = PERIOD,
        clock: Clock = time.monotonic,
    ) -> None:
        self.run = path
        self.history = HistoryBuffer()
        self._period, self._speed = period, Speed(RECENT, clock)
        self._follower = RunFollower(path)
        self._locked: bool | None = None
        self._last = Snapshot("elsewhere")

    async def __aiter__(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot every period, read in a thread."""
        while True:
            snapshot = await asyncio.to_thread(self.poll)
            yield snapshot
            if snapshot.ended:
                return
            await asyncio.sleep(self._period)

    def poll(self) -> Snapshot:
        """Return the current snapshot, with the rows and events since the last one."""
        try:
            found = self._poll()
            self._speed.add(found.generation, found.evaluations)
            self._last = replace(found, **self._speed.per_second())
        except GaitsimError as error:
            self._last = replace(self._last, state="failed", rows={}, events=(), error=error)
        return self._last

    def _poll(self) -> Snapshot:
        if not self.run.is_dir():
            raise deleted_or_moved(self.run)
        # Check the lock first: a checkpoint read after its release is the last one.
        locked = is_locked(self.run)
        run = self._follower.poll()
        if run is None and locked == self._locked:
            return replace(self._last, rows={}, events=())
        self._locked = locked
        return self._read(run or RunSnapshot(self.run), locked)

    def _read(self, run: RunSnapshot, locked: bool) -> Snapshot:
        generations = run.outline.evolution.generations
        checkpoint, warning = run.checkpoint, run.warning
        if checkpoint is None:
            return Snapshot("elsewhere" if locked else "stopped", generations=generations)
        reason = "" if locked else run.stop_reason
        rows = self._follower.read_rows(run)
        seen = len(self.history)
        self.history.extend(rows)
        stages = run.stages
        # A champion is saved before the checkpoint of its generation.
        kept = champion_generations(self.run, checkpoint.generation)
        events = events_in(self.history, stages, kept, seen + 1)
        if warning and not seen:
            events.append(Event(checkpoint.generation, "warning", warning))
        return replace(
            snapshot_of(restore_generation(checkpoint), stages[-1].outline),
            state="elsewhere" if locked else "finished" if reason else "stopped",
            reason=reason,
            generations=generations,
            scored_from=run.first_comparable,
            rows=rows,
            champion=self._champion(run, checkpoint),
            events=tuple(events),
        )

    def _champion(self, run: RunSnapshot, checkpoint: Checkpoint) -> Best | None:
        """Return the best individual so far, without its genome if that cannot be read."""
        if not np.isfinite(checkpoint.best_score):
            return None
        generation, score = checkpoint.generation - checkpoint.stagnation, checkpoint.best_score
        before = self._last.champion
        if before and (before.generation, before.score) == (generation, score) and before.genome:
            return before
        if checkpoint.stagnation == 0:
            genome = checkpoint.genomes[int(np.argmax(checkpoint.scores))]
        else:
            try:
                genome = run.best_genome(generation)
            except GaitsimError:
                return Best(generation, score)
        return Best(generation, score, tuple(genome.tolist()))
