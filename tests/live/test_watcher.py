"""Runs that this process does not control: at rest, or written by another process."""

import shutil
from functools import partial

import numpy as np
import pytest
from run_helpers import continue_run

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation import evaluate
from gaitsim.live.protocol import Best
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.files.folder import champion_file, champion_generations
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


def test_a_stopped_and_a_finished_run(new_run):
    path = new_run("run", "evolution.fitness_threshold=0")
    continue_run(path, 12)
    watch = RunWatcher(path)
    snapshot = watch.poll()
    assert (snapshot.state, snapshot.reason, snapshot.generation) == ("stopped", "", 12)
    best = RunSnapshot(path).individual()
    generation, score, genome = best.generation, best.score, best.genome
    assert (snapshot.champion.generation, snapshot.champion.score) == (generation, score)
    assert snapshot.champion.genome == tuple(genome)
    for name, values in RunSnapshot(path).history.items():
        np.testing.assert_array_equal(watch.history[name], values)
    kinds = {event.kind for event in snapshot.events}
    assert kinds == {"best", "kept"}
    assert max(e.generation for e in snapshot.events if e.kind == "best") == generation
    continue_run(path)
    snapshot = watch.poll()
    assert (snapshot.state, snapshot.reason) == ("finished", "30 generations are done")
    assert snapshot.rows["generation"].tolist() == list(range(13, 31))
    assert all(event.generation > 12 for event in snapshot.events)


def test_a_champion_is_reported_once_its_checkpoint_is_written(new_run):
    path, reported = new_run(), []
    continue_run(path, 2)
    watch = RunWatcher(path)
    watch.poll()
    for until in range(3, 31):
        early = path / champion_file(until)
        early.touch()
        reported += watch.poll().events
        early.unlink()
        continue_run(path, until)
        reported += watch.poll().events
    numbers = [event.generation for event in reported if event.kind == "kept"]
    assert numbers == [n for n in champion_generations(path) if n > 2]


async def test_a_growing_run_is_followed(new_run, monkeypatch):
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 0.0)
    path = new_run()
    seen, watch = [], RunWatcher(path, period=0)
    with RunWriter.open(path) as writer:
        generations = writer.evolve(partial(evaluate, writer.experiment))
        async for snapshot in watch:
            assert snapshot.state == "elsewhere"
            seen.append(snapshot.generation)
            if next(generations, None) is None:
                break
    last = watch.poll()
    assert seen == list(range(31))
    assert last.state == "finished"


def test_a_stage_is_reported_and_restarts_the_best_score(new_run):
    path = new_run()
    continue_run(path, 8)
    watch = RunWatcher(path)
    watch.poll()
    continue_run(path, 12, overrides={"fitness.price": 3.0})
    snapshot = watch.poll()
    assert (snapshot.stage, snapshot.scored_from) == (2, 9)
    assert snapshot.champion.generation > 8
    stage, best, *_ = snapshot.events
    assert (stage.generation, stage.kind, stage.text) == (9, "stage", "fitness.price: 0.1, now 3.0")
    assert (best.generation, best.kind) == (9, "best")


def test_without_its_plugin_only_the_champions_genome_is_missing(new_run, monkeypatch):
    path = new_run()
    continue_run(path)
    best = RunSnapshot(path).individual()
    generation, score = best.generation, best.score
    assert generation < 30

    def missing(*_):
        raise ExperimentError([GaitsimError("unknown organism plugin 'puppet'")])

    monkeypatch.setattr("gaitsim.storage.snapshot.parse_experiment", missing)
    snapshot = RunWatcher(path).poll()
    assert snapshot.champion == Best(generation, score)
    assert len(snapshot.top) == 5


@pytest.mark.parametrize(
    ("spoil", "what"),
    [
        (shutil.rmtree, "was deleted or moved"),
        (lambda path: (path / "experiment.toml").write_text("[evolution"), "experiment.toml"),
    ],
)
def test_a_damaged_run_is_a_failed_snapshot(new_run, spoil, what):
    path = new_run()
    continue_run(path, 3)
    spoil(path)
    snapshot = RunWatcher(path).poll()
    assert snapshot.state == "failed"
    assert what in str(snapshot.error)
