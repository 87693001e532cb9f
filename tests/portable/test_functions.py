"""Portable functions against mpmath, IEEE 754's special values, and themselves as plain Python."""

import itertools
import math

import mpmath
import numpy as np
import pytest
from accuracy import BOUNDS, FUNCTIONS, arguments, largest_error
from numba import njit

from gaitsim import portable
from gaitsim.portable import scalar
from gaitsim.portable.compiled import sin_and_cos


@njit
def compiled_pair(angle):
    return sin_and_cos(angle)


SPECIAL = [
    0.0, 0.5, 1.0, 2.0, 2.5, 3.0, 5e-324, 1e308, 2.0**53, 2.0**53 - 1, 2.0**70, math.inf, math.nan,
]  # fmt: skip
SPECIAL += [-x for x in SPECIAL]


@pytest.fixture(params=["compiled", "plain"])
def way(request, monkeypatch):
    """Let functions compute in compiled code, or in plain Python."""
    monkeypatch.setattr(portable, "FEW", 0 if request.param == "compiled" else math.inf)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("count", [500, pytest.param(10_000, marks=pytest.mark.slow)])
def test_errors_stay_below_the_promised_bound(name, count, monkeypatch):
    monkeypatch.setattr(portable, "FEW", 0)
    assert 0.4 < largest_error(name, count, np.random.default_rng(1)) < BOUNDS[name]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_plain_python_gives_the_bits_of_compiled_code(name, way):
    for values in arguments(name, 100, np.random.default_rng(2)):
        found = getattr(portable, name)(*values)
        with np.errstate(over="ignore"):
            plain = [getattr(scalar, name)(*map(float, one)) for one in zip(*values, strict=True)]
        np.testing.assert_array_equal(found, plain)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_special_values_are_those_of_ieee_754(name, way):
    count = 2 if name in ("power", "arctan2") else 1
    values = np.array([*itertools.product(SPECIAL, repeat=count)]).T
    found = getattr(portable, name)(*values)
    with np.errstate(all="ignore"):
        expected = getattr(np, name)(*values)
    np.testing.assert_allclose(found, expected, rtol=1e-15)
    numbers = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(found[numbers]), np.signbit(expected[numbers]))


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
@pytest.mark.parametrize(
    # The third is the double that is nearest to a multiple of π/2 (Muller 2006).
    "angle",
    [2.0**20 + 1, 1e22, 6381956970095103 * 2.0**797, -1.7976931348623157e308],
)
def test_large_angles_are_exact(name, angle):
    with mpmath.workprec(1300):
        exact = getattr(mpmath, name)(mpmath.mpf(angle))
    found = getattr(portable, name)(np.array([0.0, angle]))[1]
    assert abs(found - float(exact)) <= math.ulp(float(exact))


@pytest.mark.parametrize("run", [scalar.sin_and_cos, compiled_pair])
def test_the_pair_of_sine_and_cosine_has_the_bits_of_each(run):
    angles = [-0.0, *np.random.default_rng(3).normal(scale=9, size=300), scalar.MODERATE]
    for angle in angles:
        sine, cosine = run(angle)
        assert np.float64(sine).tobytes() == np.float64(scalar.sin(angle)).tobytes()
        assert cosine == scalar.cos(angle)
    assert all(map(math.isnan, run(math.inf)))


def test_scalars_give_scalars_and_arguments_broadcast(way):
    assert isinstance(portable.exp(1.0), float)
    assert portable.power(np.ones((3, 1)), np.ones(2)).shape == (3, 2)
    assert portable.sin(np.zeros((0, 4))).shape == (0, 4)
    assert portable.cos(np.float32(0.5)).dtype == np.float64
    strided = np.arange(12.0).reshape(3, 4).T[::2]
    np.testing.assert_array_equal(portable.exp(strided), portable.exp(strided.copy()))


def test_results_have_the_memory_layout_of_numpys(way):
    array = np.ones((4, 2, 3)).swapaxes(0, 1)
    mixed = np.broadcast_to(np.ones((4, 3)), (2, 4, 3))
    for one, other in itertools.product(
        [array, array.copy(), array[::-1], mixed, mixed[:1]], repeat=2
    ):
        assert portable.exp(one).strides == np.exp(one).strides
        assert portable.power(one, other).strides == np.power(one, other).strides
