"""A body whose score is a sum over genes, so that the gain by each change is known."""

from functools import partial

import numpy as np
import pytest
from tui_driver import config, drive, state_folder  # noqa: F401 (fixtures)

SIZE = ("evolution.population=12", "evolution.generations=15")


@pytest.fixture
def line_run(evolved_puppets):
    """Return a function that evolves puppets; it returns the run and its generations."""
    return partial(evolved_puppets, "runs/puppet", *SIZE)


@pytest.fixture
def score_of():
    """Return a function that scores a genome of a puppet, in closed form, m."""
    return lambda genome: float(np.sin(genome).sum() - 0.1 * np.abs(genome).sum())
