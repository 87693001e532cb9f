"""Portable draws against NumPy's, from the same bits."""

import numpy as np
import pytest
from scipy import stats

from gaitsim import portable


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0, 1, 7, (3, 4), 200_000])
def test_normal_draws_are_those_of_numpy(seed, size):
    one, other = np.random.default_rng(seed), np.random.default_rng(seed)
    for rng in (one, other):
        rng.integers(10, dtype=np.int32)  # leaves half of a 64-bit number
    found, expected = portable.standard_normal(one, size), other.standard_normal(size)
    # In the tails, the C library may round a logarithm differently.
    np.testing.assert_allclose(found, expected, rtol=1e-15)
    assert (found == expected).mean() > 0.999 if np.size(found) else found.shape == expected.shape
    assert one.bit_generator.state == other.bit_generator.state


def test_a_generator_of_32_bits_is_refused():
    with pytest.raises(ValueError, match="MT19937"):
        portable.standard_normal(np.random.Generator(np.random.MT19937(0)), 3)


def test_the_tails_are_normal():
    drawn = portable.standard_normal(np.random.default_rng(0), 2_000_000)
    beyond = np.abs(drawn[np.abs(drawn) > 3.654152885361009])  # where the last strip ends
    tail = stats.truncnorm(3.654152885361009, np.inf)
    assert len(beyond) == pytest.approx(2_000_000 * 2 * stats.norm.sf(3.654152885361009), rel=0.2)
    assert stats.kstest(beyond, tail.cdf).pvalue > 0.001


@pytest.mark.parametrize("probability", [0.0, 0.001, 0.05, 0.25, 0.5, 0.7, 0.999, 1.0])
@pytest.mark.parametrize("trials", [0, 1, 40, 400, 9_600, 1_000_000])
def test_binomial_draws_are_those_of_numpy(trials, probability):
    one, other = np.random.default_rng(trials), np.random.default_rng(trials)
    found = [portable.binomial(one, trials, probability) for _ in range(200)]
    assert found == other.binomial(trials, probability, 200).tolist()
    assert one.bit_generator.state == other.bit_generator.state


def test_uniform_draws_are_those_of_numpy():
    one, other = np.random.default_rng(0), np.random.default_rng(0)
    low, high = np.array([-1.0, 2.0]), np.array([1.0, 2.5])
    found = portable.uniform(one, low, high, (1000, 2))
    np.testing.assert_allclose(found, other.uniform(low, high, (1000, 2)), rtol=1e-14)
    assert one.bit_generator.state == other.bit_generator.state
