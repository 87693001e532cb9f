import math
from itertools import pairwise

import numba
import numpy as np
import pytest
from hypothesis import given, strategies as st

from gaitsim.network import (
    ACTIVATION_CODES,
    ACTIVATIONS,
    LEAK,
    Network,
    activation,
    activation_slope,
    activation_with,
    gene_count,
    gene_labels,
)
from gaitsim.portable.compiled import tanh

PLAIN = {
    "tanh": math.tanh,
    "sigmoid": lambda z: 1 / (1 + math.exp(-z)),
    "relu": lambda z: max(z, 0.0),
    "leaky-relu": lambda z: z if z > 0 else LEAK * z,
    "linear": lambda z: z,
}
SIZES = (3, 5, 4, 2)

layer_sizes = st.lists(st.integers(1, 6), min_size=2, max_size=5)
seeds = st.integers(0, 2**32 - 1)


def activate_in_loops(sizes, genes, activation, output, inputs):
    """Compute one sample, neuron by neuron, from the definition of the network."""
    values, place = list(inputs), 0
    for layer, (come, to) in enumerate(pairwise(sizes), 1):
        function = PLAIN[output if layer == len(sizes) - 1 else activation]
        before, values = values, []
        for i in range(to):
            z = genes[place + to * come + i]
            for j in range(come):
                z += genes[place + i * come + j] * before[j]
            values.append(function(z))
        place += to * (come + 1)
    return values


def drawn(sizes, seed=0, population=()):
    return np.random.default_rng(seed).normal(0, 1, (*population, gene_count(sizes)))


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("output", ACTIVATIONS)
def test_activate_agrees_with_plain_loops(activation, output):
    genes = drawn(SIZES)
    inputs = np.random.default_rng(1).normal(0, 2, (3, 7))
    answers = Network.from_genes(SIZES, genes, activation, output).activate(inputs)
    assert answers.shape == (2, 7)
    for sample in range(7):
        expected = activate_in_loops(SIZES, genes, activation, output, inputs[:, sample])
        assert answers[:, sample] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_a_population_computes_the_same_as_each_network_alone(activation):
    genes = drawn(SIZES, population=(6,))
    inputs = np.random.default_rng(1).normal(0, 1, (6, 3, 4))
    answers = Network.from_genes(SIZES, genes, activation).activate(inputs)
    assert answers.shape == (6, 2, 4)
    for n in range(6):
        alone = Network.from_genes(SIZES, genes[n], activation)
        assert answers[n] == pytest.approx(alone.activate(inputs[n]), abs=1e-12)


@given(layer_sizes, st.lists(st.integers(1, 3), max_size=2), seeds)
def test_genes_and_network_round_trip(sizes, population, seed):
    genes = drawn(sizes, seed, population)
    network = Network.from_genes(sizes, genes)
    assert network.sizes == tuple(sizes)
    assert np.array_equal(network.genes, genes)
    again = Network(network.weights, network.biases)
    assert np.array_equal(again.genes, genes)
    assert len(gene_labels(sizes)) == gene_count(sizes) == genes.shape[-1]
    assert len(set(gene_labels(sizes))) == gene_count(sizes)


def test_activations_do_not_overflow():
    network = Network.from_genes((1, 1), [1.0, 0.0], output="sigmoid")
    assert network.activate([[-1e4, 0.0, 1e4]]).tolist() == [[0.0, 0.5, 1.0]]


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: gene_labels(()), "layers of nothing"),
        (lambda: Network.random((3, -1), np.random.default_rng()), "at least one neuron"),
        (lambda: Network.from_genes((3, 2), np.zeros(7)), r"\(7,\).*\(…, 8\)"),
        (lambda: Network.from_genes((3, 2), np.zeros(8), "selu"), "'selu'"),
        (lambda: Network((np.zeros((2, 3)),), ()), "1 layers"),
        (lambda: Network((np.zeros((2, 3)),), (np.zeros(3),)), r"b1 .*\(3,\).*\(2,\)"),
        (
            lambda: Network((np.zeros((2, 3)), np.zeros((1, 3))), (np.zeros(2), np.zeros(1))),
            r"W2 .*\(1, 3\).*\(…, outputs, 2\)",
        ),
        (
            lambda: Network.from_genes((3, 2), np.zeros(8)).activate(np.zeros((2, 5))),
            r"inputs .*\(2, 5\).*\(…, 3, samples\)",
        ),
    ],
)
def test_invalid_shapes_are_rejected(make, says):
    with pytest.raises(ValueError, match=says):
        make()


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_numba_compiles_the_activations_for_numbers(name):
    code = ACTIVATION_CODES[name]
    function, slope = numba.njit(activation_with(tanh)), numba.njit(activation_slope)
    z = np.array([-30.0, -1.5, -0.1, 0.1, 1.5, 30.0])
    answers = activation(code, z)
    assert [function(code, value) for value in z] == answers.tolist()
    assert answers == pytest.approx([PLAIN[name](value) for value in z], abs=1e-12)
    step = 1e-6
    rise = (activation(code, z + step) - activation(code, z - step)) / (2 * step)
    assert [slope(code, value) for value in answers] == pytest.approx(rise, abs=1e-8)
