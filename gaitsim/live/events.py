"""Events of a run, derived from its files."""

from collections.abc import Collection, Sequence

import numpy as np

from gaitsim.live.protocol import Event
from gaitsim.runs.files.folder import champion_file
from gaitsim.runs.follow import HistoryBuffer
from gaitsim.runs.stages import RunStage


def events_in(
    history: HistoryBuffer, stages: Sequence[RunStage], kept: Collection[int], first: int = 1
) -> list[Event]:
    """Return the new best scores, saved champions and stages of a run, in order.

    Args:
        history: history of the run.
        stages: stages of the run.
        kept: generations whose champions are saved in files.
        first: first generation to report.
    """
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
