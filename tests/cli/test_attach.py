"""`gaitsim attach` shows each generation of a run once, however the snapshots arrive."""

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitsim.console.displays import Display
from gaitsim.console.evolving import _Follower
from gaitsim.live.protocol import Snapshot
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.snapshot import RunSnapshot


class Recorder(Display):
    """A display that records the calls it receives."""

    def __init__(self, path, known):
        super().__init__(path, known)
        self.rows, self.states, self.stages = [], [], []

    def start_stage(self, number, first, changes, rescored):
        self.stages.append((number, first, changes, rescored is not None))

    def update(self, snapshot, rows):
        self.rows += rows
        self.states.append(snapshot.state)


@pytest.fixture
def shown():
    """Show snapshots of a run whose generations up to `seen` are already known."""

    def shown(path, snapshots, seen=0):
        known = Snapshot("running", generation=seen)
        noted = Recorder(path, known)

        async def all_of_them():
            for snapshot in snapshots:
                yield snapshot

        asyncio.run(_Follower(path, noted, known).follow(all_of_them()))
        return noted

    return shown


def part_of_history(whole, first, last, **more):
    """Return a snapshot with the rows of some generations."""
    rows = {name: values[first - 1 : last] for name, values in whole.rows.items()}
    return replace(whole, state="running", generation=last, rows=rows, events=(), **more)


def test_every_generation_is_shown_once(puppet_run, shown):
    puppet_run("evolution.generations=9")
    path = Path("run")
    whole = RunWatcher(path).poll()
    empty = replace(whole, state="paused", generation=4, rows={}, events=())
    # Generations 1 and 2 are known, 5 arrives twice, and the snapshots omit 7.
    parts = [
        part_of_history(whole, 2, 4),
        empty,
        part_of_history(whole, 5, 5),
        part_of_history(whole, 5, 6),
        part_of_history(whole, 8, 9),
    ]
    noted = shown(path, parts, seen=2)
    assert [row["generation"] for row in noted.rows] == [3, 4, 5, 6, 7, 8, 9]
    assert [type(row["evaluations"]) for row in noted.rows] == [int] * 7
    best = RunSnapshot(path).history["best"][2:]
    np.testing.assert_array_equal([row["best"] for row in noted.rows], best)
    assert noted.states == ["running", "paused", *["running"] * 3]
