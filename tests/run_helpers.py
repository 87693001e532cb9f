"""Helpers that evolve runs, interrupt them, and compare their files."""

import hashlib
import json
import struct
from functools import partial

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import parse_assignments
from gaitsim.storage.files.safe_pickle import VERSION
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

LONG = "evolution.generations=8"
THRESHOLD = "evolution.fitness_threshold=0"

STUDY = """
name = "small"
experiments = ["millipede-random", "millipede-mutation"]
set = { "evolution.generations" = 3 }
repeats = 2
target = 2.0
[axes]
"evolution.population" = [5, 7]
"organism.pairs" = [2]
[published]
millipede-random = { population = 5, generations = 4 }
"""


def events(writer):
    """Return an iterator over the next generations of a run."""
    return evolve(writer.experiment, partial(evaluate, writer.experiment), writer.last)


def record_all(writer):
    for event in events(writer):
        writer.record(event)


def continue_run(path, until=None, **options):
    """Resume a run, up to a generation if given; return the writer's warning."""
    with RunWriter.open(path, **options) as writer:
        for event in writer.evolve(partial(evaluate, writer.experiment)):
            if event.number == until:
                break
        return writer.warning


def evolve_run(path, until=None, *overrides, **options):
    """Resume a run with overrides, up to a generation if given; return a snapshot of it."""
    continue_run(path, until, overrides=parse_assignments(overrides), **options)
    return RunSnapshot(path)


def reopen(run):
    """Return a new snapshot of the same run."""
    return RunSnapshot(run.path)


def assert_same(one, other):
    """Check that two runs are equal, except for the times in their histories."""
    one, other = reopen(one), reopen(other)
    assert one.fingerprint() == other.fingerprint()
    assert (one.path / "bests.bin").read_bytes() == (other.path / "bests.bin").read_bytes()
    champions = [sorted((run.path / "champions").iterdir()) for run in (one, other)]
    assert [path.name for path in champions[0]] == [path.name for path in champions[1]]
    for a, b in zip(*champions, strict=True):
        assert a.read_bytes() == b.read_bytes()
    assert one.generation == other.generation


def strict(text):
    """Parse standard JSON, which has no NaN."""

    def reject(constant):
        raise AssertionError(constant)

    return json.loads(text, parse_constant=reject)


def names(path):
    return {item.name for item in path.iterdir()}


class Killed(BaseException):
    """Simulated death of the process."""


def kill_at(patch, owner, step, number):
    """Patch a step to raise `Killed` at call `number`, counted from 0; truncate a write."""
    real, calls = getattr(owner, step), iter(range(100))

    def stub(*arguments, **options):
        if next(calls) == number:
            if step == "write":
                real(arguments[0], arguments[1][:9])
            raise Killed
        return real(*arguments, **options)

    patch.setattr(owner, step, stub)


def seal(payload: bytes, version: int = VERSION, more: int = 0) -> bytes:
    """Return a file with a valid digest, from a second implementation of the format."""
    start = b"GAITSIM\0" + struct.pack("<IQ", version, len(payload) + more)
    return start + hashlib.sha256(start + payload).digest() + payload
