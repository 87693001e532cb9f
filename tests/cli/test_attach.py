"""`gaitsim attach` shows each generation of a run once, however the snapshots arrive."""

import asyncio
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from gaitsim.console.displays import Display
from gaitsim.console.evolving import _Follower
from gaitsim.evaluation import evaluate
from gaitsim.live.protocol import Snapshot
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.history import row
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


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


def test_rows_whose_islands_are_not_on_disk_yet_are_shown_later(
    puppet, shown, monkeypatch, tmp_path
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 1e9)
    path = create_run(
        puppet("islands.number=2", "islands.migrants=1", "evolution.generations=5"), Path("run")
    )

    def snapshots():
        with RunWriter.open(path) as writer:
            generations = list(islice(writer.evolve(partial(evaluate, writer.experiment)), 4))
            table = [row(generation) for generation in generations]
            rows = {name: np.array([one[name] for one in table]) for name in table[0]}
            bests = tuple(generations[-1].scores.reshape(2, -1).max(axis=1))
            yield Snapshot("running", generation=4, rows=rows, islands=bests)
        yield Snapshot("stopped", generation=4, islands=bests)

    noted = shown(path, snapshots())
    found = RunSnapshot(path)
    assert [one["generation"] for one in noted.rows] == [1, 2, 3, 4]
    np.testing.assert_array_equal([one["islands"] for one in noted.rows], found.islands)
