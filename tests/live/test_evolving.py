"""The evolution of a run under commands, in this process."""

import errno
import json
import os
import random
import threading

import numpy as np
import pytest

from gaitsim.experiment import Typed
from gaitsim.live.evolving import CommandQueue, evolve_live
from gaitsim.live.protocol import RunCommand, Snapshot, read_snapshot
from gaitsim.live.reporter import Reporter
from gaitsim.storage import writer as writing
from gaitsim.storage.lock import RunLock
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class Lines(list):
    def write(self, data):
        self.append(data)

    def snapshots(self):
        last, found = Snapshot("preparing"), []
        for line in self:
            last = read_snapshot(line, last)
            found.append(last)
        return found


def steer(path, *commands, **options):
    """Evolve a run with these commands queued; return the reported snapshots."""
    queued, lines = CommandQueue(), Lines()
    for command in commands:
        queued.add(command if isinstance(command, RunCommand) else RunCommand(command))
    state = evolve_live(path, queued, Reporter(lines.write, period=0), **options)
    snapshots = lines.snapshots()
    assert snapshots[-1].state == state
    return snapshots


def change(*assignments):
    pairs = (text.partition("=") for text in assignments)
    return RunCommand("set", {key: Typed(value) for key, _, value in pairs})


def fingerprint(path):
    return RunSnapshot(path).fingerprint()


def uninterrupted(new_run, *overrides, **options):
    path = new_run("uninterrupted", *overrides, **options)
    steer(path)
    return path


def test_a_generation_of_failures_has_no_champion(new_run, puppets, monkeypatch):
    monkeypatch.setattr(
        puppets.Reach, "terms", lambda self, motion: {"far": np.full(motion.population, np.nan)}
    )
    snapshots = steer(new_run("run", "evolution.population=12", generations=3))
    assert snapshots[-1].state == "finished"
    assert all(snapshot.champion is None for snapshot in snapshots)
    assert not any(event.kind == "best" for snapshot in snapshots for event in snapshot.events)


def test_a_run_evolves_to_the_end_and_reports_all_rows(new_run):
    path = new_run()
    snapshots = steer(path)
    last = snapshots[-1]
    assert (last.state, last.reason) == ("finished", "30 generations are done")
    assert (last.generation, last.generations, last.evaluations) == (30, 30, 180)
    numbers = [n for snapshot in snapshots for n in snapshot.rows.get("generation", ())]
    assert numbers == list(range(1, 31))
    history = RunSnapshot(path).history
    reported = [n for snapshot in snapshots for n in snapshot.rows.get("mean:reach", ())]
    assert reported == history["mean:reach"].tolist()
    assert last.top[0].score == history["best"][-1]
    assert sum(last.top[0].terms.values()) == pytest.approx(last.top[0].score)
    scores = [individual.score for individual in last.top]
    assert scores == sorted(scores, reverse=True)
    assert len(scores) == 5
    best = RunSnapshot(path).individual()
    generation, score, genome = best.generation, best.score, best.genome
    assert (last.champion.generation, last.champion.score) == (generation, score)
    assert last.champion.genome == tuple(genome)


@pytest.mark.parametrize("seed", range(2))
def test_stops_pauses_and_steps_do_not_change_the_run(new_run, seed):
    drawn = random.Random(seed)
    path = new_run()
    while RunSnapshot(path).generation < 30:
        done = RunSnapshot(path).generation
        steps = drawn.randrange(1, 10)
        commands = ["pause", *["step"] * steps, *drawn.choice([[], ["go", "pause", "step"]])]
        snapshots = steer(path, *commands, "stop")
        assert snapshots[-1].generation == min(done + commands.count("step"), 30)
    assert fingerprint(path) == fingerprint(uninterrupted(new_run))


@pytest.mark.parametrize(
    "assignments", [("mutation.plugin=none",), ("fitness.price=0.5", "search.elites=0")]
)
def test_a_change_equals_a_resume_with_options(new_run, gaitsim, assignments):
    path, other = new_run("one"), new_run("other")
    steps = ["pause", *["step"] * 7]
    snapshots = steer(path, *steps, change(*assignments), "go")
    events = [event for snapshot in snapshots for event in snapshot.events]
    stages = [event for event in events if event.kind == "stage"]
    assert {event.generation for event in stages} == {8}
    assert len(stages) == len(assignments)
    assert snapshots[-1].stage == 2
    steer(other, *steps, "stop")
    gaitsim("resume", other, *(part for text in assignments for part in ("--set", text)))
    assert fingerprint(path) == fingerprint(other)
    assert fingerprint(path) != fingerprint(uninterrupted(new_run))


def test_an_invalid_change_is_reported_and_has_no_effect(new_run):
    path = new_run()
    invalid = [change("mutation.rat=1"), change("evolution.population=50"), change("x")]
    snapshots = steer(path, "pause", "step", *invalid, "step", change(), "go")
    errors = [str(snapshot.error) for snapshot in snapshots if snapshot.error]
    assert any("rat" in error for error in errors)
    assert "failed" not in {snapshot.state for snapshot in snapshots}
    assert fingerprint(path) == fingerprint(uninterrupted(new_run))


def test_a_finished_run_is_reported_and_continues_with_more_generations(new_run):
    path = new_run(generations=5)
    steer(path)
    last = steer(path)[-1]
    assert (last.state, last.reason, last.generation) == ("finished", "5 generations are done", 5)
    assert last.champion is not None
    assert len(last.top) == 5
    assert steer(path, generations=30)[-1].generation == 30
    assert fingerprint(path) == fingerprint(uninterrupted(new_run))


def test_a_run_locked_by_another_process_is_reported(new_run):
    path = new_run()
    lock = RunLock(path)
    snapshot = steer(path)[-1]
    lock.release()
    assert snapshot.state == "failed"
    assert f"is being written by process {os.getpid()}" in snapshot.error.what
    assert snapshot.error.remedy


SPOILT = """
import gaitsim_puppets as puppets
calls = 0
class Body(puppets.Puppet):
    def move(self, genomes):
        global calls
        calls += len(genomes) > 1
        if calls == 3:
            calls = 4
            raise ValueError("[/red] out of joint")
        return super().move(genomes)
"""


def test_a_broken_plugin_is_reported_and_the_run_resumes(new_run, install):
    install("spoilt", SPOILT, {"organism": {"spoilt": "Body"}})
    path = new_run("run", "organism.plugin=spoilt")
    snapshot = steer(path)[-1]
    assert (snapshot.state, snapshot.generation) == ("failed", 2)
    assert "organism 'spoilt' of package spoilt 1.0" in snapshot.error.what
    assert "gaitsim resume run" in snapshot.error.remedy
    assert steer(path)[-1].state == "finished"
    assert (
        RunSnapshot(path).history["best"].tolist()
        == RunSnapshot(uninterrupted(new_run)).history["best"].tolist()
    )


def test_a_failed_run_can_be_opened_once_it_is_reported(new_run, monkeypatch):
    path = new_run()
    opened = []

    class Eager(Lines):
        def write(self, data):
            super().write(data)
            if json.loads(data)["state"] == "failed":
                with RunWriter.open(path) as writer:
                    opened.append(writer.last)

    def fail(*_):
        with writing.writing(path):
            raise FULL

    monkeypatch.setattr(writing.history, "row", fail)
    assert evolve_live(path, CommandQueue(), Reporter(Eager().write, period=0)) == "failed"
    assert opened == [None]


def test_a_client_that_has_read_a_state_is_greeted_with_it():
    greetings = []

    def on_state(state, error):
        client = threading.Thread(target=lambda: greetings.append(reporter.full_snapshot()))
        client.start()  # in the middle of the publication
        clients.append(client)
        client.join(0.1)

    clients = []
    reporter = Reporter(lambda line: None, on_state=on_state)
    reporter.state("paused")
    clients[0].join()
    assert [json.loads(line)["state"] for line in greetings] == ["paused"]
    reporter.state("stopped")


def test_the_best_of_each_island_is_reported(new_run):
    path = new_run("run", "islands.number=3", "islands.migrants=1", generations=12)
    last = steer(path)[-1]
    assert last.islands == tuple(RunSnapshot(path).islands[-1])
    assert steer(new_run("plain", generations=3))[-1].islands == ()
