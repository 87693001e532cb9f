"""The reflex `heading` is a PI controller of the yaw, with limits."""

import numpy as np
import pytest
from bench import INTERVAL, observation, start, step

from gaitsim_reflexes.heading import Heading

DEGREE = np.pi / 180


def yaws(*degrees, **parts):
    orientation = [[0, 0, yaw * DEGREE] for yaw in degrees]
    return observation(len(degrees), orientation=orientation, **parts)


def test_it_turns_back_by_the_gain_up_to_the_limit():
    reflex = Heading(gain=4.0, integral_gain=0.0, limit=30.0)
    command = step(reflex, yaws(0, -5, 5, -40, 40)).command
    assert command[:, 1] / DEGREE == pytest.approx([0, 20, -20, 30, -30])
    assert (command[:, [0, 2, 3]] == [0.2, 0, 0]).all()


def test_it_takes_the_short_way_round():
    reflex = Heading(gain=1.0, integral_gain=0.0, limit=360.0)
    seen = yaws(170, -170, 725, heading=np.array([-170, 170, 0]) * DEGREE)
    assert step(reflex, seen).command[:, 1] / DEGREE == pytest.approx([20, -20, -5])


def test_the_integral_cancels_a_constant_drift():
    """A body that turns by u − d: the yaw of a PI loop converges to the heading, by its poles."""
    reflex, drift, yaw = Heading(gain=4.0, integral_gain=2.0), 6.0 * DEGREE, 0.0
    state = start(reflex)
    for _ in range(round(20 / INTERVAL)):
        command = step(reflex, yaws(yaw / DEGREE), state).command
        yaw += (command[0, 1] - drift) * INTERVAL
    assert abs(yaw) < 1e-5
    assert state["integral"][0] == pytest.approx(drift, rel=1e-3)
    # Without the integral, the drift leaves an error of drift / gain.
    plain, yaw = Heading(gain=4.0, integral_gain=0.0), 0.0
    for _ in range(round(20 / INTERVAL)):
        yaw += (step(plain, yaws(yaw / DEGREE)).command[0, 1] - drift) * INTERVAL
    assert yaw == pytest.approx(-drift / 4)


def test_the_integral_is_bounded_and_rests_at_the_limit_and_while_standing():
    reflex = Heading(gain=1.0, integral_gain=10.0, limit=30.0, bound=3.0)
    state = start(reflex, 4)
    seen = yaws(-5, -5, -90, 5)
    seen.command[1] = [0, 0, 0, 0.01]  # stands, a little higher
    for _ in range(100):
        command = step(reflex, seen, state).command
    assert state["integral"] / DEGREE == pytest.approx([3, 0, 0, -3])
    assert command[:, 1] / DEGREE == pytest.approx([8, 0, 30, -8])


def test_options_may_be_genes():
    reflex = Heading(integral_gain=0.0).model_copy(update={"gain": np.array([1.0, 2.0])})
    assert step(reflex, yaws(-5, -5)).command[:, 1] / DEGREE == pytest.approx([5, 10])
