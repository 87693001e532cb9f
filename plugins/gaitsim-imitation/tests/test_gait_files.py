"""Imitating gait files gives the same network as imitating runs, on a found or given body."""

import json
import shutil

import numpy as np
import pytest

import gaitsim as gs
from gaitsim import registry
from gaitsim.experiment import load_experiment
from gaitsim.gait.gait_files import Gait, gait_of, read_gait, write_gait
from gaitsim.individual import Individual
from gaitsim_imitation import load_imitator


@pytest.fixture(scope="module")
def champion():
    """Return the champion of an unrecorded run of spiders."""
    experiment = load_experiment("spider")
    genome = experiment.space().random(1, np.random.default_rng(3))[0]
    return Individual(experiment, 0.0, {}, 1, genome)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def same(one, other):
    networks = one.imitator.network, other.imitator.network
    return (
        all(map(np.array_equal, networks[0].weights, networks[1].weights))
        and all(map(np.array_equal, networks[0].biases, networks[1].biases))
        and np.array_equal(one.commanded, other.commanded)
    )


@pytest.mark.parametrize("format", ["mat", "npz", "csv"])
def test_an_exported_gait_gives_the_same_network_as_its_run(format, champion, folder, gaitsim):
    gs.export(champion, f"bestGait.{format}")
    gaitsim("imitate", f"bestGait.{format}", "--body", "spider", "--epochs", 3)
    learnt = gs.imitate(champion, epochs=3)
    assert same(load_imitator(folder / "imitator.npz"), learnt.imitation)
    assert (folder / "imitator-error.png").is_file()
    assert read_gait(folder / "imitator-gait.mat").angles.shape == (300, 24)


def test_joint_names_determine_the_body(champion, folder, gaitsim, monkeypatch):
    known = registry.entries
    few = {
        name: known(registry.EXPERIMENTS)[name] for name in ("walker", "spider-genetic", "spider")
    }
    # The other presets take seconds to import.
    monkeypatch.setattr(
        registry, "entries", lambda kind: few if kind == registry.EXPERIMENTS else known(kind)
    )
    gs.export(champion, "bestGait.mat")
    said = gaitsim("imitate", "bestGait.mat", "--epochs", 1)
    assert "the preset spider." in said.stderr


def test_a_file_in_the_exports_of_a_run_has_the_body_of_the_run(champion, folder, gaitsim):
    source = champion.experiment.to_toml().replace('name = "spider"', 'name = "mine"', 1)
    exports = folder / "mine" / "exports"
    exports.mkdir(parents=True)
    (folder / "mine" / "experiment.toml").write_text(source)
    gs.export(champion, exports / "bestGait.csv")
    said = json.loads(gaitsim("imitate", exports / "bestGait.csv", "--epochs", 1, "--json").stdout)
    assert "mine" in said["body"]
    assert said["files"]["imitator"] == str(exports / "imitator.npz")
    given = gaitsim("imitate", "mine/exports/bestGait.csv", "--body", "mine", "--epochs", 1)
    assert "mine" in given.stderr


def test_a_file_without_joint_names_uses_the_given_body(champion, folder):
    gait = gait_of(champion)
    between = (gait.angles[:-1] + gait.angles[1:]) / 2
    finer = np.stack([gait.angles[:-1], between], axis=1).reshape(-1, 24)
    np.savez(folder / "finer.npz", bestGait=finer, frameRate=2 * gait.frame_rate)
    result = gs.imitate("finer.npz", body="spider", epochs=1)
    np.testing.assert_allclose(result.expert.gait.angles, gait.angles[:-1], atol=1e-6)
    assert result.expert.gait.frame_rate == gait.frame_rate
    files = result.save(folder / "out", "csv")
    assert all(path.is_file() for path in files.values())


def test_angles_beyond_the_limits_are_learnt_and_counted(champion, folder, gaitsim):
    wide = 5 * gait_of(champion).angles
    np.savez(folder / "wide.npz", bestGait=wide)
    said = gaitsim("imitate", "wide.npz", "--body", "spider", "--epochs", 1, "--json")
    assert 0 < json.loads(said.stdout)["expert_beyond_limits"] < wide.size
    learnt = load_imitator(folder / "imitator.npz")
    assert np.array_equal(learnt.commanded[0], wide[0])
    exact = gs.imitate(champion, epochs=1)
    assert exact.expert_beyond_limits == 0


def test_without_play_an_imitator_has_no_score(puppet, folder, gaitsim):
    angles = np.sin(np.arange(12.0)).reshape(4, 3)
    (folder / "puppet.toml").write_text(puppet().to_toml())
    names = tuple(puppet().organism.joint_names())
    write_gait(Gait(angles, names, 4.0, 1, 0.0), folder / "gait.mat", "mat")
    said = gaitsim("imitate", "gait.mat", "--body", "puppet.toml", "--epochs", 2)
    assert "cannot play joint angles" in said.stdout
    refused = gaitsim("imitate", "gait.mat", "--body", "puppet.toml", "--video", code=2)
    assert "cannot play given joint angles" in refused.stderr
    np.savez(folder / "rateless.npz", bestGait=angles)
    refused = gaitsim("imitate", "rateless.npz", "--body", "puppet.toml", code=2)
    assert "no frame rate" in refused.stderr


ANGLES = np.zeros((3, 24))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("unnamed.npz",), "--body"),
        pytest.param(("foreign.npz",), "a body with the 2 joints of", marks=pytest.mark.slow),
        (("foreign.npz", "--body", "spider"), "which this body does not have"),
        (("unnamed.npz", "--body", "fly"), "no joint angles"),
        (("imitator.npz", "--body", "spider"), "would replace the imitated gait file imitator.npz"),
    ],
)
def test_invalid_input_is_one_message(arguments, says, folder, gaitsim):
    (folder / "run").mkdir()
    (folder / "notes.txt").write_text("no gait")
    np.savez(folder / "unnamed.npz", bestGait=ANGLES)
    np.savez(folder / "short.npz", bestGait=ANGLES[:1])
    np.savez(folder / "nan.npz", bestGait=ANGLES * np.nan)
    np.savez(folder / "foreign.npz", bestGait=ANGLES[:, :2], jointNames=["hip", "knee"])
    shutil.copy(folder / "unnamed.npz", folder / "imitator.npz")
    said = gaitsim("imitate", *arguments, code=2)
    assert says in said.stderr
    assert "Traceback" not in said.stderr
    assert not list(folder.glob("imitator-*"))
