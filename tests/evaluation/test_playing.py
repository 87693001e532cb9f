import numpy as np
import pytest

from gaitsim.contracts import Channel, Motion
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.playing import play, require_play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.experiment import load_experiment


def by_angles(self, joint_angles):
    reach = np.sin(joint_angles[:, -1]).sum(axis=1)
    return Motion(4.0, {"joint_angles": joint_angles, "reach": reach})


@pytest.fixture
def playable(puppet, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Puppet, "play", by_angles, raising=False)
    return puppet()


def test_playing_the_angles_of_a_champion_gives_its_score():
    experiment = load_experiment("spider")
    genomes = experiment.space().random(3, np.random.default_rng(0))
    moved = evaluate(experiment, genomes)
    angles = experiment.organism.move(genomes)["joint_angles"]
    played = evaluate_motion(experiment, play(experiment, angles), 3)
    assert np.array_equal(played.scores, moved.scores)
    assert list(played.terms) == list(moved.terms)


def test_a_body_that_cannot_play_is_refused(puppet, puppets, monkeypatch):
    experiment = puppet()
    with pytest.raises(GaitsimError, match=r"gaitsim-puppets.* cannot play"):
        require_play(experiment)
    with pytest.raises(GaitsimError, match="body Puppet cannot play"):
        experiment.organism.play(np.zeros((1, 5, 3)))
    monkeypatch.setattr(puppets.Puppet, "channels", {"reach": Channel((), "m", "")})
    with pytest.raises(GaitsimError, match="has no joint angles"):
        require_play(experiment)


@pytest.mark.parametrize(
    ("angles", "says"),
    [
        (np.zeros((5, 3)), r"shape \(5, 3\) do not fit organism 'puppet'"),
        (np.zeros((1, 1, 3)), "3 joints and at least 2 frames"),
        (np.full((1, 5, 3), np.nan), "not finite"),
    ],
)
def test_angles_of_another_body_are_refused(playable, angles, says):
    with pytest.raises(GaitsimError) as error:
        play(playable, angles)
    assert not isinstance(error.value, PluginError)
    error.match(says)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda self, angles: 1 / 0, "failed while playing joint angles: ZeroDivisionError"),
        (lambda self, angles: Motion(4.0, {"reach": angles}), "playing joint angles: KeyError"),
        (
            lambda self, angles: Motion(4.0, {"joint_angles": angles[:, 1:]}),
            r"joint_angles of shape \(1, 4, 3\)",
        ),
    ],
)
def test_a_body_that_breaks_its_contract_is_named(playable, puppets, monkeypatch, wrong, says):
    monkeypatch.setattr(puppets.Puppet, "play", wrong)
    with pytest.raises(PluginError, match=f"package gaitsim-puppets.* {says}"):
        play(playable, np.zeros((1, 5, 3)))
