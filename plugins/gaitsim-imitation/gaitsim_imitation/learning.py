"""Train a network on a gait."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Activation, GaitsimError, OutputActivation, unknown
from gaitsim.plugin.toolkit import ACTIVATION_CODES, Network, cos, standard_normal
from gaitsim_imitation.imitator import Angles, Imitator

ACTIVATIONS, OUTPUTS = get_args(Activation), get_args(OutputActivation)
CHUNK = 20  # epochs between calls of `progress`, a few hundredths of a second
_WEIGHTS, _ORDER, _NOISE = range(3)  # purposes of random numbers
_RANGES: Mapping[str, tuple[Any, float, float]] = {
    "hidden": (int, 1, 4096),
    "epochs": (int, 1, 1_000_000),
    "learning_rate": (int | float, 1e-9, 10),
    "noise": (int | float, 0, 10),
    "seed": (int, 0, 2**128),
}


@dataclass(frozen=True)
class TrainingSettings:
    """The settings of a training.

    Attributes:
        activation: activation of the hidden layer.
        output: activation of the outputs, 'linear' or 'same' as the hidden layer.
        hidden: number of neurons in the hidden layer.
        epochs: number of passes over all pairs.
        learning_rate: step size along the gradient of half the squared error.
        decay: whether the learning rate falls to zero along half a cosine.
        noise: standard deviation of the noise on the inputs, in the network's units.
        normalise: whether to measure the inputs from the middle of each joint's range, in units
            of the largest range; otherwise they are angles in radians.
        seed: seed of the initial weights, the order of the pairs, and the noise.
    """

    activation: str = "leaky-relu"
    output: str = "linear"
    hidden: int = 48
    epochs: int = 1000
    learning_rate: float = 0.008
    decay: bool = False
    noise: float = 0.0
    normalise: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        for name, known in (("activation", ACTIVATIONS), ("output", OUTPUTS)):
            if getattr(self, name) not in known:
                raise unknown(name, getattr(self, name), known)
        for name, (kind, low, high) in _RANGES.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, kind) or not low <= value <= high:
                noun = "a whole number" if kind is int else "a number"
                raise GaitsimError(
                    f"invalid {name!r} for an imitator: {value!r:.80}",
                    key=name,
                    allowed=f"{noun}, {low:,} to {high:,}",
                )


SETTINGS = {
    "source": TrainingSettings(),
    # Noise teaches the network to return to the gait. The decay prevents the last pairs of the
    # training from biasing the network.
    "steady": TrainingSettings(
        epochs=3000, learning_rate=0.02, decay=True, noise=0.05, normalise=True
    ),
}


def learn(
    expert: Angles,
    settings: TrainingSettings,
    progress: Callable[[int], object] = lambda epochs: None,
) -> tuple[Imitator, NDArray[np.float64]]:
    """Train a network on pairs of consecutive frames of a gait, one pair per step.

    The same gait and settings give exactly the same network.

    Args:
        expert: gait to learn, (frames, joints), radians, at least 2 frames.
        settings: settings of the training.
        progress: called with the number of epochs since the last call.

    Returns:
        The imitator, and its mean squared error over all pairs and joints after each epoch,
        (epochs,), rad².
    """
    from gaitsim_imitation.descent import descend

    centre, scale = _units(expert, settings.normalise)
    frames = (expert - centre) / scale
    inputs, targets = np.ascontiguousarray(frames[:-1]), np.ascontiguousarray(frames[1:])
    output = settings.activation if settings.output == "same" else settings.output
    joints = expert.shape[1]
    network = Network.random(
        (joints, settings.hidden, joints), _rng(settings, _WEIGHTS), settings.activation, output
    )
    rates = np.full(settings.epochs, settings.learning_rate)
    if settings.decay:
        rates *= (1 + cos(np.pi * np.arange(settings.epochs) / settings.epochs)) / 2
    errors = np.empty(settings.epochs)
    w1, w2 = (weight.astype(np.float64) for weight in network.weights)
    b1, b2 = (bias.astype(np.float64) for bias in network.biases)
    codes = ACTIVATION_CODES[settings.activation], ACTIVATION_CODES[output]
    for part, orders, noise in _draws(settings, *inputs.shape):
        descend(
            w1, b1, w2, b2, *codes, inputs, targets, orders, noise, rates[part], errors[part]
        )  # fmt: skip
        if not np.isfinite(errors[part]).all():
            epoch = part.start + int(np.argmin(np.isfinite(errors[part]))) + 1
            raise GaitsimError(
                f"training diverged: the error is not finite in epoch {epoch}",
                where=f"learning rate {settings.learning_rate:g}",
                remedy="try a smaller learning rate",
            )
        progress(len(errors[part]))
    learnt = Network((w1, w2), (b1, b2), settings.activation, output)
    return Imitator(learnt, centre, scale), errors * (scale * scale)


def prepare() -> None:
    """Compile the training, or load its compiled code from the cache."""
    learn(np.zeros((2, 1)), TrainingSettings(hidden=1, epochs=1))


def _rng(settings: TrainingSettings, purpose: int) -> np.random.Generator:
    return np.random.default_rng([settings.seed, purpose])


def _units(expert: Angles, normalise: bool) -> tuple[NDArray[np.float64], float]:
    """Return the angles at which inputs are 0, and the difference from them for an input of 1."""
    if not normalise:
        return np.zeros(expert.shape[1]), 1.0
    low, high = expert.min(axis=0), expert.max(axis=0)
    return (low + high) / 2, float((high - low).max()) or 1.0


def _draws(
    settings: TrainingSettings, pairs: int, joints: int
) -> Iterator[tuple[slice, NDArray[np.int64], NDArray[np.float64]]]:
    """Yield chunks of epochs with orders of pairs and noise, which do not depend on `CHUNK`."""
    order, noise = _rng(settings, _ORDER), _rng(settings, _NOISE)
    for first in range(0, settings.epochs, CHUNK):
        part = slice(first, min(first + CHUNK, settings.epochs))
        epochs = range(part.start, part.stop)
        orders = np.stack([order.permutation(pairs) for _ in epochs])
        added = np.empty((len(epochs), 0, 0))
        if settings.noise:
            added = settings.noise * np.stack(
                [standard_normal(noise, (pairs, joints)) for _ in epochs]
            )
        yield part, orders, added
