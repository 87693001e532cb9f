"""The video of an imitator: the error of its training, then both bodies."""

import av
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


@pytest.mark.slow
def test_python_and_the_command_write_the_video(result, tmp_path, monkeypatch, gaitsim):
    monkeypatch.chdir(tmp_path)
    path = result.video("small.gif", size=(160, 120), fps=8, dark=True)
    assert path.stat().st_size > 1000
    gs.export(result.expert.individual, "bestGait.npz")
    said = gaitsim("imitate", "bestGait.npz", "--body", "spider", "--epochs", 2, "--video")
    assert "imitator.mp4" in said.stdout
    with av.open("imitator.mp4") as container:
        shown = container.streams.video[0]
        assert (shown.width, shown.height) == (1280, 720)
        assert sum(1 for _ in container.decode(shown)) == 345


def test_ctrl_c_during_the_video_writes_nothing(result, tmp_path, monkeypatch, gaitsim):
    from gaitsim.render.film import Film

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    gs.export(result.expert.individual, "bestGait.npz")
    monkeypatch.setattr(Film, "_draw", interrupted)
    said = gaitsim(
        "imitate", "bestGait.npz", "--body", "spider", "--epochs", 2, "--video", code=130
    )
    assert "nothing was written" in said.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["bestGait.npz"]
