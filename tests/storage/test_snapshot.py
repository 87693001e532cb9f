"""A snapshot of a run reads each of its files once, and so does each command."""

from functools import partial

import pytest

from gaitsim.evaluation import evaluate
from gaitsim.storage.files.folder import CHECKPOINT
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


def count(paths):
    return [path.name for path in paths].count(CHECKPOINT)


@pytest.fixture
def run(puppet_run):
    return puppet_run().path


def test_a_snapshot_reads_its_checkpoint_once(run, checkpoint_reads):
    snapshot = RunSnapshot(run)
    assert not checkpoint_reads
    first = snapshot.individual()
    assert snapshot.individual().generation == first.generation == snapshot.best_generation
    assert snapshot.generation == len(snapshot.history["best"]) == len(snapshot.bests)
    assert snapshot.fingerprint()
    assert [stage.last for stage in snapshot.stages] == [snapshot.generation]
    assert not snapshot.pending
    assert count(checkpoint_reads) == 1


def test_a_snapshot_stays_as_it_was_while_the_run_grows(run):
    before = RunSnapshot(run)
    last = before.generation
    with RunWriter.open(run, generations=last + 2) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass
    assert (before.generation, len(before.history["best"]), len(before.bests)) == (last,) * 3
    assert RunSnapshot(run).generation == last + 2


@pytest.mark.parametrize("command", ["show", "runs", "analyse"])
def test_a_command_reads_the_checkpoint_once(gaitsim, puppet_file, checkpoint_reads, command):
    gaitsim("run", puppet_file, "--generations", "3")
    checkpoint_reads.clear()
    gaitsim(command, *(() if command == "runs" else ("puppet",)))
    assert count(checkpoint_reads) == 1
