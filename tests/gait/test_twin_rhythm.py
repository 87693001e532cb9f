"""Gaits of the kinematic spider as rhythms of its twin in physics."""

import numpy as np
import pytest

from gaitsim.api import evolve
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait.changed import has_rhythm_on_twin, play_on_twin, rhythm_on_twin
from gaitsim.individual import Individual
from gaitsim.steering import SteeredDrive


@pytest.fixture(scope="module", params=["sine", "cpg"])
def champion(request):
    search = evolve(
        "spider", generations=20, seed=1, set={"organism.encoding": request.param}, workers=1
    )
    for _ in search:
        pass
    return search.champion


@pytest.mark.slow
def test_a_champion_walks_on_the_twin_as_far_as_its_joint_angles(champion):
    twin, about = rhythm_on_twin(champion)
    assert has_rhythm_on_twin(champion)
    assert not has_rhythm_on_twin(twin)
    assert "spider-physics" in about
    assert about.endswith("joint angles within 0.1°.")
    tape = play_on_twin(champion).measures["forward"]
    assert twin.measures["forward"] == pytest.approx(tape, rel=0.2)
    assert twin.replayed_score == twin.score


@pytest.mark.slow
def test_a_champion_turns_as_told(champion):
    twin, about = rhythm_on_twin(champion)
    drive = SteeredDrive(twin.experiment, {"gait": twin.genome}, about)
    for command in ("faster", "faster", "faster", "left"):
        drive.give(command)
    drive.advance_to(1.0)
    drive.advance_to(2.0)
    turned = drive.turned
    told = np.radians(float(drive.facts["set turn"].split()[0]))
    for second in (3.0, 4.0, 5.0):
        drive.advance_to(second)
    assert drive.turned - turned == pytest.approx(3 * told, rel=0.25)


def individual(angles):
    """Return an individual of the spider with joint angles, (frames, 24) rad."""
    experiment = load_experiment("spider")
    motion = experiment.organism.play(angles[None])
    genome = experiment.space().random(1, np.random.default_rng(0))[0]
    return Individual(experiment, 0.0, {}, 1, genome, played=motion)


@pytest.mark.parametrize(
    ("wave", "problem"),
    [
        (np.zeros_like, "no stride repeats"),
        (
            lambda cycle: 0.2 * (np.sin(cycle) + np.sin(3 * cycle)),
            "from the nearest gait of spider-physics",
        ),
    ],
)
def test_gaits_far_from_sines_are_refused(wave, problem):
    cycle = 2 * np.pi * 0.5 * np.arange(301)[:, None] / 30 + np.arange(24)
    with pytest.raises(GaitsimError, match=problem):
        rhythm_on_twin(individual(wave(cycle)))
