from functools import cache
from pathlib import Path

import pytest

from gaitsim.evaluation import judge
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.runs.folder import create_run
from gaitsim.runs.reader import Run
from gaitsim.runs.writer import RunWriter


def evolved(experiment, path):
    path = create_run(experiment, path)
    with RunWriter(path) as writer:
        for generation in evolve(experiment, lambda genomes: judge(experiment, genomes)):
            writer.record(generation)
    return Run(path)


@pytest.fixture(scope="module")
def spider(tmp_path_factory):
    """A finished run of three generations of ten spiders."""
    experiment = load_experiment(
        "spider-recurrence", ["evolution.population=10", "evolution.generations=3"]
    )
    return evolved(experiment, tmp_path_factory.mktemp("export") / "spider")


@pytest.fixture(scope="session")
def bundled(tmp_path_factory):
    """Makes a finished run of a preset, of one generation; the same one for the same preset."""

    @cache
    def run(preset):
        experiment = load_experiment(preset, ["evolution.population=21", "evolution.generations=1"])
        return evolved(experiment, tmp_path_factory.mktemp("bundled") / preset)

    return run


@pytest.fixture
def puppet_run(puppet, tmp_path, monkeypatch):
    """Makes a finished run of puppets."""
    monkeypatch.chdir(tmp_path)
    return lambda *overrides: evolved(puppet(*overrides), Path("run"))
