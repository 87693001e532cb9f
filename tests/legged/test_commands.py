"""Delayed commands, and commands at a lower rate than the frames."""

import numpy as np
import pytest

from gaitsim.legged import delay_angles, hold_commands

RAMP = np.arange(20.0)[:, None] * [1.0, -2.0]


def test_a_ramp_is_delayed_by_whole_and_fractional_steps():
    late = delay_angles(np.stack([RAMP, 3 * RAMP]), np.array([1.5, 3.0]))
    assert late[0, 4:, 0] == pytest.approx(RAMP[4:, 0] - 1.5)
    assert np.array_equal(late[1, 3:, 1], 3 * RAMP[:-3, 1])
    assert (late[:, :2] == 0).all()


@pytest.mark.parametrize("rate", [30.0, 7.0, 3.7])
def test_each_command_is_held_until_the_next_one_is_sent(rate):
    found = hold_commands(RAMP, 30.0, rate, steps=4)[:-4, 0]
    times = np.arange(len(found)) / 120  # s
    sent = np.floor(times * rate + 1e-9) / rate
    assert found == pytest.approx(30 * sent)
    assert np.array_equal(hold_commands(RAMP, 30.0, 30.0, steps=4), np.repeat(RAMP, 4, axis=0))
