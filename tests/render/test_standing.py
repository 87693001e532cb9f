"""Feet that are marked as standing are on the ground, in every kind of picture."""

from typing import NamedTuple

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.scene.clip import clip_of
from gaitsim_exports.gltf.glb import glb
from gaitsim_page.clips import clip_data
from gaitsim_page.packing import unpack
from gaitsim_spider.body import FOOT_RADIUS
from gaitsim_spider.walking import STANCE_TOLERANCE
from tests.gltf import Gltf


class Case(NamedTuple):
    """A body, the height of a foot's centre on the ground, and the error of its contacts, m."""

    preset: str
    options: dict
    height: float = FOOT_RADIUS
    error: float = STANCE_TOLERANCE


CASES = {
    "spider": Case("spider", {}),
    "spider without two legs": Case("spider", {"organism.damage": ["L2 lost", "R3 lost"]}),
    "spider with weak servos": Case("spider", {"organism.world": {"servo_speed": 0.7}}),
    "spider-recurrence": Case("spider-recurrence", {}),
    "millipede": Case("millipede", {}, 0.0, 1e-9),
    # Contacts in rigid-body physics are soft, and a step of the simulation may end in between.
    "walker": Case("walker-four", {}, 0.025, 0.005),
    "hexapod": Case("hexapod", {}, 0.0, 0.005),
}


@pytest.fixture(params=CASES)
def standing(request):
    """An individual, and the largest height at which a foot stands."""
    case = CASES[request.param]
    experiment = load_experiment(case.preset, case.options)
    starts = experiment.starts() or {
        "random": experiment.space().random(1, np.random.default_rng(5))[0]
    }
    genome = next(iter(starts.values()))
    individual = Individual(experiment, 0.0, {}, 1, genome)
    assert individual.skeleton.touching.sum(axis=1).mean() >= 1  # something to see
    return individual, case.height + case.error + 1e-6


def test_in_pictures_videos_and_terminals(standing):
    individual, highest = standing
    clip = clip_of(individual)
    rate, frames = clip.skeleton.frame_rate, len(clip.path)
    between = np.random.default_rng(0).uniform(0, frames / rate, 200)
    for time in [*between, *(np.arange(frames) / rate)]:
        pose = clip.at(time)
        assert pose.contacts[pose.touching, 2].max(initial=0) <= highest


def test_in_pages(standing):
    individual, highest = standing
    feet = clip_data(individual)["feet"]
    heights, down = unpack(feet["points"])[..., 2], unpack(feet["touching"]) > 0
    assert heights[down].max() <= highest + 1e-5


def test_in_gltf_files(standing):
    individual, highest = standing
    skeleton, file = individual.skeleton, Gltf(glb(individual))
    for index, name in enumerate(skeleton.contact_names):
        (node,) = [n for n in file.numbers(name) if "mesh" not in file.nodes[n]]
        for frame in np.flatnonzero(skeleton.touching[:, index])[::5]:
            place = file.value(node, "translation", frame / skeleton.frame_rate)
            assert place[2] <= highest
