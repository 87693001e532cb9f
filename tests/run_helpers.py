"""How tests write runs: evolve them, stop them, and compare their files."""

import hashlib
import struct
from functools import partial

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.runs.files.safe_pickle import VERSION
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.writer import RunWriter

LONG = "evolution.generations=8"
THRESHOLD = "evolution.fitness_threshold=0"


def events(writer):
    """The generations that follow in a run."""
    return evolve(writer.experiment, partial(evaluate, writer.experiment), writer.last)


def record_all(writer):
    for event in events(writer):
        writer.record(event)


def go_on(path, until=None, **options):
    """Evolve a run, at most to a generation; what its writer warned of."""
    with RunWriter.open(path, **options) as writer:
        for event in writer.evolve(partial(evaluate, writer.experiment)):
            if event.number == until:
                break
        return writer.warning


def again(run):
    """The same run as it is now."""
    return RunSnapshot(run.path)


def assert_same(one, other):
    """Two runs hold the same, but for the times in their histories."""
    one, other = again(one), again(other)
    assert one.fingerprint() == other.fingerprint()
    assert (one.path / "bests.bin").read_bytes() == (other.path / "bests.bin").read_bytes()
    champions = [sorted((run.path / "champions").iterdir()) for run in (one, other)]
    assert [path.name for path in champions[0]] == [path.name for path in champions[1]]
    for a, b in zip(*champions, strict=True):
        assert a.read_bytes() == b.read_bytes()
    assert one.generation == other.generation


def names(path):
    return {item.name for item in path.iterdir()}


class Killed(BaseException):
    """As if the process were gone."""


def kill_at(patch, owner, step, number):
    """Let the n-th call of a step, counted from 0, raise `Killed`; a write is then cut short."""
    real, calls = getattr(owner, step), iter(range(100))

    def stub(*arguments, **options):
        if next(calls) == number:
            if step == "write":
                real(arguments[0], arguments[1][:9])
            raise Killed
        return real(*arguments, **options)

    patch.setattr(owner, step, stub)


def seal(payload: bytes, version: int = VERSION, more: int = 0) -> bytes:
    """A file with a right digest: the format, written down a second time."""
    start = b"GAITSIM\0" + struct.pack("<IQ", version, len(payload) + more)
    return start + hashlib.sha256(start + payload).digest() + payload
