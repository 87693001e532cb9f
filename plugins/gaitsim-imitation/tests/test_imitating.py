"""Imitators of the default spider's champion: training, playing and evaluation."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import gaitsim as gs
from gaitsim.contracts import Motion
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.film import RenderSettings
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter
from gaitsim_imitation import load_imitator
from gaitsim_imitation.imitating import imitate, imitation_film
from gaitsim_imitation.learning import SETTINGS, TrainingSettings


def evolved(experiment, path):
    with RunWriter.open(create_run(experiment, path)) as writer:
        for generation in evolve(experiment, partial(evaluate, experiment)):
            writer.record(generation)
    return RunSnapshot(path)


@pytest.fixture(scope="module")
def spider(tmp_path_factory):
    """Evolve the default spider for fewer generations, and return the run."""
    experiment = load_experiment("spider", {"evolution.generations": 80})
    return evolved(experiment, tmp_path_factory.mktemp("imitation") / "spider")


@pytest.fixture
def puppet_run(puppet, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return evolved(puppet(), tmp_path / "run")


@pytest.mark.parametrize(
    "settings", [pytest.param(SETTINGS[name], id=name, marks=pytest.mark.slow) for name in SETTINGS]
)
def test_the_imitator_walks_nine_tenths_of_the_distance(spider, settings):
    expert = spider.individual()
    result = imitate(expert, settings)
    whole, reached = (individual.measures["forward"] for individual in (expert, result.played))
    assert whole > 2.0
    assert result.forward_kept == reached / whole
    assert reached >= 0.9 * whole
    assert result.imitation.commanded.shape == (300, 24)
    # It really walks: it moves every joint that the expert moves.
    moved = np.ptp(expert.joint_angles, axis=0) > 0.1
    assert (np.ptp(result.imitation.commanded, axis=0)[moved] > 0.05).all()
    assert result.one_step < 1e-5
    assert result.free_running < 0.02


def test_the_expert_walks_straight_and_never_falls(spider):
    measures = spider.individual().measures
    assert measures["forward"] >= 2.6
    assert abs(measures["yaw"]) < 10
    assert abs(measures["lateral"]) < 0.15
    assert measures["slip ratio"] < 0.15
    assert measures["least margin"] > 0


@pytest.mark.slow
def test_commanded_angles_beyond_the_limits_are_counted(spider):
    result = imitate(spider.individual(), SETTINGS["source"])
    played, commanded = result.imitation.gait.angles, result.imitation.commanded
    assert result.beyond_limits == np.count_nonzero(np.abs(played - commanded) > 1e-6)
    assert np.abs(np.diff(played, axis=0)).max() <= np.radians(5) + 1e-6
    assert np.abs(played).max() <= np.radians(30) + 1e-6


def test_the_command_writes_and_prints_everything(spider, gaitsim, tmp_path):
    said = json.loads(gaitsim("imitate", spider.path, "--json", "--epochs", 40).stdout)
    files = said["files"]
    imitation = load_imitator(spider.path / "exports" / "imitator.npz")
    assert imitation.gait.joint_names[0] == "L1 coxa"
    mat = loadmat(files["gait"])
    assert np.array_equal(mat["bestGait"], imitation.gait.angles)
    assert mat["score"].item() == said["imitator"]["score"]
    assert said["angles"] == 7200
    assert said["settings"]["epochs"] == 40
    assert list(said["expert"]["terms"]) == list(said["imitator"]["terms"])
    drawn = Path(files["error"]).read_bytes()
    assert drawn.startswith(b"\x89PNG")
    again = json.loads(
        gaitsim("imitate", spider.path, "--json", "--epochs", 40, "--out", tmp_path).stdout
    )
    assert {**again, "files": files} == said
    assert np.array_equal(load_imitator(tmp_path / "imitator.npz").commanded, imitation.commanded)
    assert (tmp_path / "imitator-error.png").read_bytes() == drawn


@pytest.mark.slow
def test_all_activations_are_compared(spider, gaitsim, tmp_path):
    said = gaitsim(
        "imitate", spider.path, "--compare-activations", "--epochs", 30,
        "--settings", "steady", "--activation", "tanh", "--format", "csv", "--out", tmp_path,
    )  # fmt: skip
    for name in ("leaky-relu", "relu", "tanh", "sigmoid"):
        assert f"training, {name}: 30 epochs" in said.stderr
        assert f"\n{name} " in said.stdout
    assert "network 24-48-24, tanh" in said.stdout
    written = {path.name for path in tmp_path.iterdir()}
    assert {
        "imitator.npz", "imitator-gait.csv", "imitator-error.png", "imitator-activations.png",
    } <= written  # fmt: skip
    assert load_imitator(tmp_path / "imitator.npz").imitator.network.activation == "tanh"


def test_a_third_party_body_with_play(puppet_run, puppets, monkeypatch, gaitsim):
    def play(self, joint_angles):
        held = np.clip(joint_angles, -1.0, 1.0)
        return Motion(4.0, {"joint_angles": held, "reach": np.sin(held[:, -1]).sum(axis=1)})

    monkeypatch.setattr(puppets.Puppet, "play", play)
    plain = json.loads(gaitsim("imitate", puppet_run.path, "--epochs", 2, "--json").stdout)
    assert set(plain["imitator"]["terms"]) == {"reach", "price"}
    assert plain["forward_kept"] is None


def test_an_imitator_whose_motion_fails_scores_minus_infinity(puppet_run, puppets, monkeypatch):
    def play(self, joint_angles):
        reach = joint_angles[:, -1].sum(axis=1)
        return Motion(4.0, {"joint_angles": joint_angles, "reach": reach}, None, {0: "fell apart"})

    monkeypatch.setattr(puppets.Puppet, "play", play)
    result = imitate(puppet_run.individual(), TrainingSettings(epochs=2))
    assert result.played.score == -np.inf


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("run", "--activation", "selu"), "selu"),
        (("run", "--epochs", "0"), "epochs"),
        (("run", "--seed", "-1"), "seed"),
        (("run", "--out", "run/experiment.toml/new"), "experiment.toml is not a folder"),
    ],
)
def test_invalid_input_is_one_message(puppet_run, gaitsim, arguments, says):
    said = gaitsim("imitate", *arguments, code=2)
    assert says in said.stderr
    assert not (puppet_run.path / "exports" / "imitator.npz").exists()


def test_ctrl_c_writes_nothing(puppet_run, gaitsim, monkeypatch):
    import gaitsim_imitation.imitating as module

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "learn", interrupted)
    said = gaitsim("imitate", puppet_run.path, code=130)
    assert "Stopped; nothing was written." in said.stderr
    assert not list((puppet_run.path / "exports").iterdir())


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
