"""Compiled stochastic gradient descent for a network with one hidden layer."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import activation_slope, activation_with, compiled_tanh as tanh

Floats = NDArray[np.float64]


_activated = njit(inline="always")(activation_with(tanh))
_slope = njit(inline="always")(activation_slope)


@njit(inline="always")
def _layer(weights: Floats, biases: Floats, inputs: Floats, code: int, outputs: Floats) -> None:
    for i in range(weights.shape[0]):
        z = biases[i]
        for j in range(weights.shape[1]):
            z += weights[i, j] * inputs[j]
        outputs[i] = _activated(code, z)


@njit(inline="always")
def _step(weights: Floats, biases: Floats, inputs: Floats, delta: Floats, rate: float) -> None:
    for i in range(weights.shape[0]):
        step = rate * delta[i]
        for j in range(weights.shape[1]):
            weights[i, j] -= step * inputs[j]
        biases[i] -= step


@njit(nogil=True, cache=True)
def descend(
    w1: Floats,
    b1: Floats,
    w2: Floats,
    b2: Floats,
    code: int,
    output: int,
    inputs: Floats,
    targets: Floats,
    orders: NDArray[np.int64],
    noise: Floats,
    rates: Floats,
    errors: Floats,
) -> None:
    """Train for some epochs, one pair at a time, changing the network's arrays in place.

    Each step follows the gradient of half the squared error, summed over the outputs.

    Args:
        w1: weights of the hidden layer, (hidden, inputs).
        b1: biases of the hidden layer, (hidden,).
        w2: weights of the outputs, (outputs, hidden).
        b2: biases of the outputs, (outputs,).
        code: activation of the hidden layer; see `gaitsim.network`.
        output: activation of the outputs.
        inputs: inputs, (pairs, inputs).
        targets: targets, (pairs, outputs).
        orders: order of the pairs in each epoch, (epochs, pairs).
        noise: noise on the inputs, (epochs, pairs, inputs); (epochs, 0, 0) for none.
        rates: learning rate of each epoch, (epochs,).
        errors: array for the result, (epochs,): mean squared error over all pairs and outputs
            after each epoch, without noise.
    """
    pairs, joints = targets.shape
    seen, hidden = np.empty(inputs.shape[1]), np.empty(len(b1))
    answer, delta, back = np.empty(joints), np.empty(joints), np.empty(len(b1))
    for epoch in range(len(rates)):
        for turn in range(pairs):
            pair = orders[epoch, turn]
            for j in range(len(seen)):
                seen[j] = inputs[pair, j]
            if noise.shape[1]:
                for j in range(len(seen)):
                    seen[j] += noise[epoch, turn, j]
            _layer(w1, b1, seen, code, hidden)
            _layer(w2, b2, hidden, output, answer)
            for i in range(joints):
                delta[i] = (answer[i] - targets[pair, i]) * _slope(output, answer[i])
            back[:] = 0.0
            for i in range(joints):
                for j in range(len(hidden)):
                    back[j] += w2[i, j] * delta[i]
            for j in range(len(hidden)):
                back[j] *= _slope(code, hidden[j])
            _step(w2, b2, hidden, delta, rates[epoch])
            _step(w1, b1, seen, back, rates[epoch])
        total = 0.0
        for pair in range(pairs):
            _layer(w1, b1, inputs[pair], code, hidden)
            _layer(w2, b2, hidden, output, answer)
            for i in range(joints):
                total += np.square(answer[i] - targets[pair, i])
        errors[epoch] = total / (pairs * joints)
