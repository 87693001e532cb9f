"""The evolution of one run: opened, prepared, evolved and closed."""

import numpy as np
import pytest

from gaitsim.errors import PluginError, RunError
from gaitsim.storage.creation import create_run
from gaitsim.storage.lock import is_locked
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


@pytest.fixture
def begun(puppet, tmp_path):
    """A function that creates the folder of a run of puppets with five generations."""

    def begun(name="run", *overrides):
        return create_run(puppet("evolution.generations=5", *overrides), tmp_path / name)

    return begun


def evolve(path, until=None, **options):
    with RunWriter.open(path, workers=1, **options) as writer:
        for generation in writer.evolve():
            if generation.number == until:
                break
        return writer


def test_a_stopped_run_continues_to_the_same_result(begun):
    path, whole = begun(), begun("whole")
    evolve(path, 2)
    assert RunSnapshot(path).generation == 2
    evolve(path)
    evolve(whole)
    assert RunSnapshot(path).fingerprint() == RunSnapshot(whole).fingerprint()


def test_a_finished_run_says_why_and_evolves_no_generation(begun):
    path = begun()
    evolve(path)
    with RunWriter.open(path) as writer:
        assert writer.done == "5 generations are done"
        assert list(writer.evolve()) == []
    assert not is_locked(path)


def test_a_stage_with_other_scores_is_reevaluated_once(begun):
    path = begun()
    evolve(path, 3)
    with RunWriter.open(path, overrides={"fitness.price": 3.0}, workers=1) as writer:
        before = writer.last.scores
        assert writer.reevaluates
        writer.reevaluate()
        assert not writer.reevaluates
        assert not np.array_equal(writer.last.scores, before)
        assert [generation.number for generation in writer.evolve()] == [4, 5]


def test_an_error_while_evolving_says_how_to_resume(begun, puppets, monkeypatch):
    path = begun()
    monkeypatch.setattr(puppets.Puppet, "move", lambda *_: 1 / 0)
    with pytest.raises(PluginError) as raised:
        evolve(path)
    assert f"gaitsim resume {path}" in raised.value.remedy
    assert not is_locked(path)


def test_an_error_while_opening_leaves_the_run_unlocked(begun):
    path = begun()
    evolve(path)
    with pytest.raises(RunError):
        evolve(path, generations=2)
    assert not is_locked(path)
