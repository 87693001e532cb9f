"""The video of an imitator: the error of its training, then both bodies."""

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.experiment import load_experiment
from gaitsim.imitation.imitating import imitation_film
from gaitsim.individual import Individual
from gaitsim.render.film import RenderSettings


@pytest.fixture(scope="module")
def result():
    experiment = load_experiment("spider")
    genome = experiment.space().random(1, np.random.default_rng(3))[0]
    return gs.imitate(Individual(experiment, 0.0, {}, 1, genome), epochs=2)


def test_the_video_shows_the_error_and_then_both_bodies(result):
    film = imitation_film(result, RenderSettings(size=(320, 240), fps=2, speed=5))
    curve, *_, last = film.pictures()
    assert curve.shape == last.shape == (240, 320, 4)
    assert not np.array_equal(curve, last)
    bare = imitation_film(result, RenderSettings(size=(320, 240), fps=2, speed=5, intro=False))
    assert len(film) == len(bare) + 3  # 1.5 s
    assert len(bare.scene.world.clips) == 2
    assert [clip.tag for clip in bare.scene.world.clips] == ["expert", "imitator"]
