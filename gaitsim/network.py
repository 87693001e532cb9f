"""Feed-forward networks in NumPy: a single one or a whole population at once.

The first layer is the input. Layer k has weights W, (to, from), where W[i, j] connects neuron j of
the previous layer to neuron i, and biases b, (to,). Samples are columns: A ← f(W A + b).

All arrays may have leading axes, such as the population. Every function works on the last axes
only, so that one call processes all individuals.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.portable import matmul, standard_normal, tanh

Floats = NDArray[np.float64]

LEAK = 0.01
"""Slope of the leaky ReLU below zero."""


TANH, SIGMOID, RELU, LEAKY_RELU, LINEAR = range(5)
ACTIVATIONS = ("tanh", "sigmoid", "relu", "leaky-relu", "linear")
"""Names of the activations, ordered by code; 'linear' is meant for the last layer."""
ACTIVATION_CODES = {name: code for code, name in enumerate(ACTIVATIONS)}


def activation_with(tanh: Callable[[Any], Any]) -> Callable[[int, Any], Any]:
    """Return a variant of `activation` that uses the given hyperbolic tangent."""

    def activation(code: int, z: Any) -> Any:
        """Return f(z) for an array, or for a number if compiled by Numba."""
        if code == TANH:
            return tanh(z)
        if code == SIGMOID:  # equals 1 / (1 + exp(−z)), without its overflow for large −z
            return (1 + tanh(z / 2)) / 2
        if code == RELU:
            return np.maximum(z, 0)
        if code == LEAKY_RELU:
            return np.maximum(z, LEAK * z)
        return z

    return activation


activation = activation_with(tanh)


def activation_slope(code: int, a: Any) -> Any:
    """Return f'(z) given a = f(z), for an array, or for a number if compiled by Numba."""
    if code == TANH:
        return 1 - a * a
    if code == SIGMOID:
        return a * (1 - a)
    if code == RELU:
        return np.sign(a)
    if code == LEAKY_RELU:
        return np.maximum(np.sign(a), LEAK)
    return 1.0


def gene_count(sizes: Sequence[int]) -> int:
    """Return the number of weights and biases for these layer sizes, inputs first.

    Raises:
        ValueError: there are fewer than two layers, or a layer is empty.
    """
    return sum(fan_out * (fan_in + 1) for fan_in, fan_out in pairwise(_checked(sizes)))


def gene_labels(sizes: Sequence[int]) -> tuple[str, ...]:
    """Return the names of genes in the order of `Network.genes`: 'W1[0,0]', 'W1[0,1]' … 'b1[0]' …

    Raises:
        ValueError: there are fewer than two layers, or a layer is empty.
    """
    return tuple(
        label
        for layer, (fan_in, fan_out) in enumerate(pairwise(_checked(sizes)), 1)
        for label in (
            *(f"W{layer}[{i},{j}]" for i in range(fan_out) for j in range(fan_in)),
            *(f"b{layer}[{i}]" for i in range(fan_out)),
        )
    )


@dataclass(frozen=True, eq=False)
class Network:
    """A feed-forward network, or several along leading axes.

    Attributes:
        weights: weights W1, W2 …, each (…, to, from).
        biases: biases b1, b2 …, each (…, to).
        activation: activation of the hidden layers, one of `ACTIVATIONS`.
        output: activation of the last layer.

    Raises:
        ValueError: shapes do not match, or an activation is unknown.
    """

    weights: tuple[Floats, ...]
    biases: tuple[Floats, ...]
    activation: str = "tanh"
    output: str = "linear"

    def __post_init__(self) -> None:
        for name in (self.activation, self.output):
            if name not in ACTIVATIONS:
                raise ValueError(f"activation {name!r} is not one of {', '.join(ACTIVATIONS)}")
        if not self.weights or len(self.weights) != len(self.biases):
            raise ValueError(
                f"{len(self.weights)} layers of weights and {len(self.biases)} of biases: "
                "expected equal numbers, at least one"
            )
        inputs: int | None = None
        for layer, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True), 1):
            shape = weight.shape
            if len(shape) < 2 or inputs not in (None, shape[-1]):
                raise ValueError(
                    f"W{layer} has shape {shape}; expected (…, outputs, {inputs or 'inputs'})"
                )
            if bias.shape != shape[:-1]:
                raise ValueError(
                    f"b{layer} has shape {bias.shape}; expected {shape[:-1]} to match W{layer}"
                )
            inputs = shape[-2]

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of neurons in each layer, inputs first."""
        return (self.weights[0].shape[-1], *(weight.shape[-2] for weight in self.weights))

    @property
    def genes(self) -> Floats:
        """All parameters as one axis, (…, genes): W1 row by row, b1, W2, b2 …"""
        parts: list[Floats] = []
        for weight, bias in zip(self.weights, self.biases, strict=True):
            parts += [weight.reshape(*weight.shape[:-2], -1), bias]
        return np.concatenate(parts, axis=-1)

    @classmethod
    def from_genes(
        cls,
        sizes: Sequence[int],
        genes: ArrayLike,
        activation: str = "tanh",
        output: str = "linear",
    ) -> "Network":
        """Return the network with these parameters; its arrays are views of `genes`.

        Args:
            sizes: number of neurons in each layer, inputs first.
            genes: parameters, (…, genes), such as (population, genes), in the order of
                `Network.genes`.
            activation: activation of the hidden layers.
            output: activation of the last layer.

        Raises:
            ValueError: the number of genes does not match the sizes, or an activation is unknown.
        """
        count = gene_count(sizes)
        row = np.asarray(genes, np.float64)
        if row.ndim == 0 or row.shape[-1] != count:
            raise ValueError(
                f"genes have shape {row.shape}; expected (…, {count}) for layers of "
                f"{'-'.join(map(str, sizes))}"
            )
        weights, biases, first = [], [], 0
        for fan_in, fan_out in pairwise(sizes):
            middle, last = first + fan_out * fan_in, first + fan_out * (fan_in + 1)
            weights.append(row[..., first:middle].reshape(*row.shape[:-1], fan_out, fan_in))
            biases.append(row[..., middle:last])
            first = last
        return cls(tuple(weights), tuple(biases), activation, output)

    @classmethod
    def random(
        cls,
        sizes: Sequence[int],
        rng: np.random.Generator,
        activation: str = "tanh",
        output: str = "linear",
    ) -> "Network":
        """Return an untrained network with Gaussian weights and biases of zero.

        The variance of a weight is 2/from before a ReLU (He et al. 2015) and 1/from otherwise
        (LeCun et al. 1998), which preserves the variance of signals across layers.

        Raises:
            ValueError: there are fewer than two layers, a layer is empty, or an activation is
                unknown.
        """
        layers = list(pairwise(_checked(sizes)))
        gains = [2.0 if "relu" in activation else 1.0] * (len(layers) - 1)
        gains.append(2.0 if "relu" in output else 1.0)
        return cls(
            tuple(
                np.sqrt(gain / fan_in) * standard_normal(rng, (fan_out, fan_in))
                for (fan_in, fan_out), gain in zip(layers, gains, strict=True)
            ),
            tuple(np.zeros(fan_out) for _, fan_out in layers),
            activation,
            output,
        )

    def activate(self, inputs: ArrayLike) -> Floats:
        """Return the outputs of the network.

        Args:
            inputs: inputs, (…, inputs, samples), one sample per column; without leading axes, all
                networks of a population receive the same inputs.

        Returns:
            The outputs, (…, outputs, samples).

        Raises:
            ValueError: the inputs do not match the first layer.
        """
        a = np.asarray(inputs, np.float64)
        if a.ndim < 2 or a.shape[-2] != self.sizes[0]:
            raise ValueError(f"inputs have shape {a.shape}; expected (…, {self.sizes[0]}, samples)")
        for layer, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            a = activation(self._code(layer), matmul(weight, a) + bias[..., None])
        return a

    def _code(self, layer: int) -> int:
        last = layer == len(self.weights) - 1
        return ACTIVATION_CODES[self.output if last else self.activation]


def _checked(sizes: Sequence[int]) -> Sequence[int]:
    if len(sizes) < 2 or any(size < 1 for size in sizes):
        raise ValueError(
            f"layers of {'-'.join(map(str, sizes)) or 'nothing'}: expected at least two, "
            "inputs first, each of at least one neuron"
        )
    return sizes
