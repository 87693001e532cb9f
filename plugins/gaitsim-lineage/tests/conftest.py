"""A body whose score is a sum over genes, so that the gain by each change is known."""

from functools import partial

import numpy as np
import pytest
from tui_driver import config, drive, state_folder  # noqa: F401 (fixtures)

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

SIZE = ("evolution.population=12", "evolution.generations=15")


@pytest.fixture
def line_run(puppet, here):
    """Return a function that evolves puppets; it returns the run and its generations."""

    def record(*options):
        path = create_run(puppet(*SIZE, *options), here / "runs" / "puppet")
        kept = []
        with RunWriter.open(path) as writer:
            for generation in evolve(writer.experiment, partial(evaluate, writer.experiment)):
                writer.record(generation)
                kept.append(generation)
        return RunSnapshot(path), kept

    return record


@pytest.fixture
def score_of():
    """Return a function that scores a genome of a puppet, in closed form, m."""
    return lambda genome: float(np.sin(genome).sum() - 0.1 * np.abs(genome).sum())
