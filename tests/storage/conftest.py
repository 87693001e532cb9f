import math
from pathlib import Path

import numpy as np
import pytest
from run_helpers import LONG, THRESHOLD, continue_run

from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import Champion, Checkpoint
from gaitsim.storage.snapshot import RunSnapshot


@pytest.fixture(scope="session")
def checkpoint():
    """A function that creates a checkpoint of four individuals, the second of which failed."""
    return _checkpoint


@pytest.fixture(scope="session")
def champion():
    """A function that creates a champion with given changes."""
    return _champion


def _checkpoint(**changes):
    rng = np.random.default_rng(0)
    values = {
        "experiment": 'organism = "spider"\n',
        "versions": {"gaitsim": "0.1.0", "plugin spider": "gaitsim 0.1.0"},
        "generation": 7,
        "genomes": rng.normal(size=(4, 3)),
        "scores": np.array([1.5, -math.inf, -0.0, 2.5]),
        "terms": {
            "speed": np.array([1.0, np.nan, 0.0, 2.0]),
            "slip": np.array([0.5, math.inf, 0, 0.5]),
        },
        "reasons": {"1": "speed is not a number"},
        "stagnation": 2,
        "best_score": 2.5,
        "threshold": 2.0,
        "stages": (),
        "values": {"yaw": np.array([1.0, np.nan, -2.0, 0.5])},
        "state": {"mean": np.arange(3.0), "empty": np.empty((0, 3), np.int64)},
    }
    values |= changes
    return Checkpoint(**{"evaluations": values["generation"] * len(values["genomes"])} | values)


def _champion(**changes):
    values = {
        "experiment": 'organism = "spider"\n',
        "versions": {"gaitsim": "0.1.0"},
        "generation": 7,
        "genome": np.array([0.5, -1.0]),
        "score": 1.5,
        "terms": {"speed": 1.0, "slip": 0.5},
    }
    return Champion(**values | changes)


@pytest.fixture
def gathering(monkeypatch):
    """Saves generations only where they must be, however slow the machine is."""
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 1e9)


@pytest.fixture
def whole(puppet, here):
    """A run of eight generations that was never interrupted."""
    path = create_run(puppet(LONG, THRESHOLD), Path("whole"))
    continue_run(path)
    return RunSnapshot(path)


@pytest.fixture
def half(puppet, here):
    """The same run, stopped after generation 4."""
    path = create_run(puppet(LONG, THRESHOLD), Path("half"))
    continue_run(path, 4)
    return RunSnapshot(path)
