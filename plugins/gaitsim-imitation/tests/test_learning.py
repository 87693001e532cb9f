import itertools

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.network import ACTIVATION_CODES, Network
from gaitsim_imitation import learning as module
from gaitsim_imitation.descent import descend
from gaitsim_imitation.learning import ACTIVATIONS, SETTINGS, TrainingSettings, learn


def waves(frames=40, joints=3, period=20.0, amplitude=0.3):
    """Return a gait of one sine with a different phase for each joint."""
    time = np.arange(frames)[:, None]
    return amplitude * np.sin(2 * np.pi * time / period + np.arange(joints))


@pytest.mark.parametrize(("activation", "output"), itertools.product(ACTIVATION_CODES, repeat=2))
def test_a_step_follows_the_networks_gradient(activation, output):
    rng = np.random.default_rng(0)
    network = Network.random((3, 5, 3), rng, activation, output)
    seen, wanted, rate = rng.normal(size=(1, 3)), rng.normal(size=(1, 3)), 0.1

    def error(genes):
        answers = Network.from_genes((3, 5, 3), genes, activation, output).activate(seen.T)
        return np.square(answers - wanted.T).sum() / 2

    genes = network.genes
    steps = 1e-6 * np.eye(len(genes))
    slopes = np.array([(error(genes + step) - error(genes - step)) / 2e-6 for step in steps])
    (w1, w2), (b1, b2) = network.weights, network.biases
    errors = np.empty(1)
    descend(
        w1, b1, w2, b2, ACTIVATION_CODES[activation], ACTIVATION_CODES[output], seen, wanted,
        np.zeros((1, 1), np.int64), np.empty((1, 0, 0)), np.array([rate]), errors,
    )  # fmt: skip
    assert network.genes == pytest.approx(genes - rate * slopes, abs=1e-8)
    assert errors[0] == pytest.approx(2 / 3 * error(network.genes), abs=1e-12)  # a mean of 3


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_a_seed_determines_the_network_whatever_the_chunks(settings, monkeypatch):
    short = TrainingSettings(**{**vars(settings), "epochs": 7})
    one, errors = learn(waves(), short)
    monkeypatch.setattr(module, "CHUNK", 3)
    two, again = learn(waves(), short)
    assert one.network.genes.tobytes() == two.network.genes.tobytes()
    assert errors.tobytes() == again.tobytes()
    other, _ = learn(waves(), TrainingSettings(**{**vars(short), "seed": 1}))
    assert not np.array_equal(one.network.genes, other.network.genes)


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_the_error_falls(settings, activation):
    chosen = TrainingSettings(**{**vars(settings), "activation": activation, "epochs": 400})
    imitator, errors = learn(waves(), chosen)
    standing = np.mean(np.diff(waves(), axis=0) ** 2)  # the error of repeating the input
    assert errors[-1] < standing / 3
    assert errors[-1] < errors[0]
    assert imitator.one_step_error(waves()) == pytest.approx(errors[-1], rel=1e-9)
    assert imitator.network.sizes == (3, 48, 3)


def test_free_running_starts_from_the_first_frame():
    expert = waves()
    imitator, _ = learn(expert, TrainingSettings(activation="tanh"))
    played = imitator.free_run(expert[0], 60)
    assert played.shape == (60, 3)
    assert np.array_equal(played[0], expert[0])
    for frame in (1, 17, 59):
        expected = imitator.predict(played[frame - 1 : frame])[0]
        assert played[frame] == pytest.approx(expected, abs=1e-12)
    assert np.abs(played[:40] - expert).max() < 0.1


def test_diverging_angles_stay_finite():
    imitator, _ = learn(waves(), TrainingSettings(epochs=1))
    wild = Network(
        tuple(100 * weight for weight in imitator.network.weights), imitator.network.biases
    )
    played = type(imitator)(wild, imitator.centre, imitator.scale).free_run(waves()[0], 500)
    assert np.isfinite(played).all()
    assert np.abs(played).max() == pytest.approx(2 * np.pi)


def test_normalised_inputs_are_zero_in_the_middle_of_the_range():
    expert = waves() + np.array([1.0, -2.0, 0.0])
    imitator, _ = learn(expert, TrainingSettings(epochs=1, normalise=True))
    assert imitator.centre == pytest.approx([1.0, -2.0, 0.0], abs=0.02)
    assert imitator.scale == pytest.approx(np.ptp(expert, axis=0).max())


def test_standing_still_can_be_learnt():
    expert = np.full((30, 2), 0.2)
    for settings in SETTINGS.values():
        imitator, _ = learn(expert, settings)
        assert imitator.free_run(expert[0], 30) == pytest.approx(expert, abs=0.02)


def test_a_diverging_training_is_an_error():
    with pytest.raises(GaitsimError, match="diverged") as error:
        learn(waves(amplitude=3.0), TrainingSettings(learning_rate=10.0))
    assert "smaller learning rate" in str(error.value)
