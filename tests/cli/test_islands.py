"""Runs with islands are bit-identical with any workers, and after being killed."""

import os

import pytest

SLOW = """
import time
from gaitsim_puppets import WindyPuppet
class Slow(WindyPuppet):
    def move(self, genomes):
        time.sleep(0.001 * len(genomes))
        return super().move(genomes)
"""
ISLANDS = (
    *("--set", "organism.plugin=slow", "--set", "worlds.number=2", "--set", "worlds.redraw=4"),
    *("--set", "islands.number=4", "--set", "islands.migrants=1", "--set", "islands.every=5"),
    *("--generations", 13),
)


@pytest.fixture(autouse=True)
def slow(puppets, install, monkeypatch):
    """Install a puppet whose individuals take long enough that workers are faster."""
    folder = install("slow", SLOW, {"organism": {"slow": "Slow"}})
    paths = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    monkeypatch.setenv("PYTHONPATH", paths)


@pytest.fixture
def evolve(gaitsim, puppet_file):
    """Return a function that evolves islands and returns the fingerprint."""

    def evolve(out, *arguments):
        gaitsim("run", puppet_file, *ISLANDS, "--out", out, *arguments)
        return gaitsim("show", out, "--fingerprint").stdout

    return evolve


@pytest.fixture
def epochs(monkeypatch):
    """Return a list that records the first and last generation of each epoch given to workers."""
    from gaitsim.evaluation.processes import ProcessExecutor

    handed, original = [], ProcessExecutor.map

    def record(self, function, tasks, *following):
        tasks = list(tasks)
        if hasattr(tasks[0], "island"):
            handed.append((len(tasks), tasks[0].first, tasks[0].last))
        return original(self, function, tasks, *following)

    monkeypatch.setattr(ProcessExecutor, "map", record)
    return handed


@pytest.mark.slow
def test_runs_are_bit_identical_with_and_without_worker_processes(evolve, gaitsim, epochs):
    alone = evolve("alone", "--workers", 1)
    assert evolve("two", "--workers", 2) == alone
    # Each task of a worker was the epoch of one island, from one migration to the next.
    assert epochs == [(4, 2, 5), (4, 6, 10), (4, 11, 13)]
    assert "identical" in gaitsim("verify", "two", "--all", "--workers", 1).stdout
    (line,) = [
        line for line in gaitsim("show", "two").stdout.splitlines() if line.startswith("4 islands")
    ]
    assert line == "4 islands on a ring; every 5 generations the best 1 of each migrate"
