"""Kinematic gaits on the physical twin of their body."""

from pathlib import Path

import numpy as np
import pytest
from rigid_body import replay

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait import compare_bodies, play_on_twin
from gaitsim.gait.gait_files import play_gait, read_gait

GAITS = Path(__file__).parents[2] / "data/gaits"


@pytest.mark.parametrize("gait", ["alternating-tetrapod", "ripple"])
def test_a_gait_walks_as_far_on_the_twin_as_in_the_independent_simulation(gait):
    file = read_gait(GAITS / f"{gait}.npz")
    individual = play_gait(file, load_experiment("spider"))
    twin = play_on_twin(individual)
    reference = replay(individual.joint_angles)
    assert twin.measures["forward"] == pytest.approx(reference.forward, rel=0.12)
    assert abs(twin.measures["yaw"] - reference.yaw) < 5
    assert twin.measures["lasted"] == pytest.approx(9.96)
    found = {one.name: one for one in compare_bodies(individual, twin)}
    forward = found["forward"]
    assert forward.own == pytest.approx(individual.measures["forward"])
    assert (forward.other, forward.unit) == (pytest.approx(twin.measures["forward"]), "m")
    assert np.isnan(found["peak torque"].own)


def test_a_body_without_a_twin_is_refused():
    twin = play_on_twin(play_gait(read_gait(GAITS / "ripple.npz"), load_experiment("spider")))
    with pytest.raises(GaitsimError, match="has no twin in rigid-body physics"):
        play_on_twin(twin)
