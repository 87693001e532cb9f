from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitsim.experiment import load_experiment

GAITS = Path(__file__).parents[2] / "data/gaits"


@pytest.fixture(scope="session")
def spider():
    """The experiment of the default spider."""
    return load_experiment("spider")


@pytest.fixture(scope="session")
def reference():
    """A reference gait's joint angles by name, (300, 24)."""

    def load(name):
        with np.load(GAITS / f"{name}.npz") as file:
            return file["joint_angles"].astype(float)

    return load


@pytest.fixture(scope="session")
def played(spider):
    """The skeleton of joint angles, (frames, 24), played on the spider."""

    def play(angles):
        motion = spider.organism.play(angles[None])
        return replace(spider.organism.skeleton(motion, 0), touching=motion["stance"][0])

    return play
