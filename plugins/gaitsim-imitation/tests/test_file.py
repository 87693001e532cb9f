import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_imitation import load_imitator
from gaitsim_imitation.imitator import Imitation, save_imitator
from gaitsim_imitation.learning import TrainingSettings, learn


@pytest.fixture(scope="module")
def imitation():
    expert = 0.3 * np.sin(np.arange(20)[:, None] + np.arange(3))
    imitator, _ = learn(expert, TrainingSettings(epochs=2, normalise=True, output="same"))
    commanded = imitator.free_run(expert[0], 20)
    gait = Gait(np.clip(commanded, -0.1, 0.1), ("a", "b", "c"), 25.0, 7, 1.5)
    return Imitation(gait, commanded, imitator, 3)


@pytest.fixture
def saved(imitation, tmp_path):
    path = tmp_path / "imitator.npz"
    save_imitator(imitation, path)
    return path


def test_a_saved_imitator_is_loaded_unchanged(imitation, saved):
    again = load_imitator(saved)
    assert again.gait.angles.tobytes() == imitation.gait.angles.tobytes()
    assert again.commanded.tobytes() == imitation.commanded.tobytes()
    assert (again.gait.frame_rate, again.gait.joint_names) == (25.0, ("a", "b", "c"))
    assert (again.gait.generation, again.gait.score, again.seed) == (7, 1.5, 3)
    before, after = imitation.imitator, again.imitator
    assert after.network.genes.tobytes() == before.network.genes.tobytes()
    assert (after.network.activation, after.network.output) == ("leaky-relu", "leaky-relu")
    # The loaded network plays the gait stored with it.
    assert np.array_equal(after.free_run(again.commanded[0], 20), imitation.commanded)


def test_the_file_is_a_gait_file_too(imitation, saved):
    with np.load(saved, allow_pickle=False) as file:
        assert np.array_equal(file["joint_angles"], imitation.gait.angles)
        assert file["frame_rate"] == 25.0
        assert file["W1"].shape == (48, 3)
        assert file["b2"].shape == (3,)
        assert str(file["units"]) == "rad"


def changed(saved, **fields):
    with np.load(saved, allow_pickle=False) as file:
        everything = {name: file[name] for name in file.files} | fields
    np.savez(saved, **{name: value for name, value in everything.items() if value is not None})


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"joint_angles": None}, "'joint_angles' is missing"),
        ({"commanded": np.full((20, 3), np.nan)}, "'commanded' has values that are not finite"),
        ({"joint_names": np.array(["a"])}, r"\(frames, 1\)"),
        ({"W2": np.zeros((3, 47))}, "W2 has shape"),
        ({"activation": "rot13"}, "rot13"),
        ({"scale": 0.0}, r"the scale \(0\.0\)"),
        ({"centre": np.array([object()] * 3)}, "allow_pickle=False"),
    ],
)
def test_foreign_files_are_rejected(saved, fields, says):
    changed(saved, **fields)
    with pytest.raises(GaitsimError, match=says):
        load_imitator(saved)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"nonsense" * 100])
def test_foreign_bytes_are_rejected(tmp_path, content):
    (tmp_path / "x.npz").write_bytes(content)
    with pytest.raises(GaitsimError, match=r"x\.npz"):
        load_imitator(tmp_path / "x.npz")
