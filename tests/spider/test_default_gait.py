"""The best spider of `gaitsim run spider` must walk, by its own measures and in physics."""

import numpy as np
import pytest

from gaitsim.evaluation import Evaluator
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment

# test_imitating.py tests the walk of a shorter run in the default suite.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def champion() -> tuple[dict[str, float], np.ndarray]:
    """Return measures and joint angles, (frames, 24), of the best spider of the default run."""
    experiment = load_experiment("spider")
    with Evaluator(experiment) as evaluator:
        for generation in evolve(experiment, evaluator.evaluate):
            last = generation
    motion = experiment.organism.move(last.genomes[last.best][None])
    measures = experiment.organism.measures(motion)
    return {k: float(m.values[0]) for k, m in measures.items()}, motion["joint_angles"][0]


def test_the_default_gait_walks_by_its_own_measures(
    champion: tuple[dict[str, float], np.ndarray],
) -> None:
    measures, _ = champion
    assert measures["forward"] >= 2.6
    assert abs(measures["yaw"]) < 10
    assert abs(measures["lateral"]) < 0.15
    assert measures["slip ratio"] < 0.15
    assert measures["least margin"] > 0


@pytest.mark.parametrize("servo", ["nominal", "30 ms delay", "30 ms first-order lag"])
def test_the_default_gait_walks_in_an_independent_rigid_body_simulation(
    champion: tuple[dict[str, float], np.ndarray], servo: str
) -> None:
    pytest.importorskip("mujoco")
    from rigid_body import VARIANTS, replay

    walked = replay(champion[1], **VARIANTS[servo])
    assert not walked.fell
    assert walked.belly == 0
    assert walked.forward >= 2.6
    assert abs(walked.yaw) < 10
