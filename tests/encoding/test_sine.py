import math
from dataclasses import replace

import numpy as np
import pytest
from robots import OSCILLATORS, ROBOT, SECONDS, drawn

from gaitsim.encoding import amplitude_limit, limit_steps


def closed_form(amplitude, phase, lag, frequency):
    argument = 2 * math.pi * np.multiply.outer(frequency, SECONDS)
    argument = np.atleast_2d(argument)[:, None] + (phase[:, OSCILLATORS] + lag)[..., None]
    return amplitude[..., None] * np.sin(argument)


def test_each_individual_swings_at_its_own_frequency():
    values = drawn(4)
    angles = ROBOT.sine(*values)
    assert angles.shape == (4, 6, 90)
    np.testing.assert_allclose(angles, closed_form(*values), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_a_shared_frequency_gives_the_same_angles(dtype, tolerance):
    *values, _ = drawn(4)
    angles = replace(ROBOT, dtype=dtype).sine(*values, 1.3)
    assert angles.dtype == dtype
    np.testing.assert_allclose(angles, closed_form(*values, 1.3), rtol=0, atol=tolerance)


@pytest.mark.parametrize("shared", [False, True])
def test_an_individual_has_the_same_bits_alone_and_in_a_population(shared):
    amplitude, phase, lag, frequency = drawn(5)
    together = ROBOT.sine(amplitude, phase, lag, 1.3 if shared else frequency)
    for i in range(5):
        own = 1.3 if shared else frequency[i : i + 1]
        alone = ROBOT.sine(amplitude[i : i + 1], phase[i : i + 1], lag[i : i + 1], own)
        assert (alone[0] == together[i]).all()


@pytest.mark.parametrize(
    ("name", "shapes"),
    [
        ("amplitude", ((4, 5), (4, 3), (4, 6), ())),
        ("phase", ((4, 6), (3, 3), (4, 6), ())),
        ("lag", ((4, 6), (4, 3), (4, 3), ())),
        ("frequency", ((4, 6), (4, 3), (4, 6), (3,))),
        ("phase", ((4, 6), (4, 2), (4, 6), ())),
    ],
)
def test_shapes_that_do_not_fit_are_refused_by_name(name, shapes):
    with pytest.raises(ValueError, match=f"^{name} "):
        ROBOT.sine(*(np.ones(shape) for shape in shapes))


def test_the_largest_amplitude_keeps_both_limits():
    limits = amplitude_limit(2.0, [0.5, 1.0], 2 * math.pi)
    np.testing.assert_allclose(limits, [0.5, 0.5])
    assert amplitude_limit(0.1, 0.5, 2 * math.pi) == 0.5


def test_limited_steps_follow_slow_angles_and_cut_fast_ones():
    angles = np.zeros((1, 2, 4), dtype=np.float32)
    angles[0, 0] = [0, 0.05, 0.1, 0.1]
    angles[0, 1] = [0, 1, 1, 0]
    limited = limit_steps(angles, 0.1)
    assert limited.dtype == np.float32
    np.testing.assert_array_equal(limited[0, 0], angles[0, 0])
    np.testing.assert_allclose(limited[0, 1], [0, 0.1, 0.2, 0.1], rtol=1e-6)
