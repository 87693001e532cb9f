"""What happened in a run, told from what is on the disk."""

import re
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from gaitsim.runs.folder import CHAMPIONS
from gaitsim.runs.stages import RunStage
from gaitsim.steering.course import Course
from gaitsim.steering.protocol import Event


def events_in(
    course: Course, stages: Sequence[RunStage], kept: Collection[int], first: int = 1
) -> list[Event]:
    """Better best scores, kept champions and stages, from a generation on, in their order.

    Args:
        course: the run's history.
        stages: of the run.
        kept: generations of which a champion's file is kept.
        first: the first generation to tell of.
    """
    found = [
        Event(stage.first, "stage", str(change))
        for stage in stages
        if stage.first >= first
        for change in stage.changes
    ]
    found += [Event(number, "kept", kept_as(number)) for number in kept if number >= first]
    for start, end in _comparable(stages, len(course)):
        best = course["best"][start - 1 : end]
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


def kept_as(generation: int) -> str:
    """Where in a run's folder the champion of a generation is kept."""
    return f"{CHAMPIONS}/generation-{generation:06d}.pickle"


def kept_champions(run: Path) -> list[int]:
    """The generations of which a run's folder keeps a champion's file."""
    names = (path.stem for path in (run / CHAMPIONS).glob("generation-*.pickle"))
    matches = (re.fullmatch(r"generation-(\d+)", name) for name in names)
    return sorted(int(match[1]) for match in matches if match)


def _comparable(stages: Sequence[RunStage], generations: int) -> list[tuple[int, int]]:
    """First and last generations whose scores can be compared with one another."""
    starts = [stage.first for stage in stages if stage.number == 1 or stage.rescored]
    return list(zip(starts, [*(start - 1 for start in starts[1:]), generations], strict=True))
