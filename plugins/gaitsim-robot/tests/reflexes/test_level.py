"""The reflex `level` lengthens the legs on the low side, and holds the trunk level on a slope."""

import numpy as np
import pytest
from bench import FEET, INTERVAL, LEGS, observation, start, step

from gaitsim_reflexes.level import Level

P_ONLY = {"pitch": 1.0, "integral_gain": 0.0, "damping": 0.0, "limit": 0.5}


@pytest.mark.parametrize(
    ("roll", "pitch", "longer"),
    [(0.1, 0, {"FR", "HR"}), (-0.1, 0, {"FL", "HL"}), (0, 0.1, {"FL", "FR"}), (0.08, 0.1, {"FR"})],
)
def test_legs_of_the_low_side_get_longer(roll, pitch, longer):
    seen = observation(orientation=[[roll, pitch, 1.0]])
    reach = step(Level(**P_ONLY), seen).reach[0]
    assert longer <= {name for name, change in zip(LEGS.names, reach, strict=True) if change > 0}
    assert max(zip(reach, LEGS.names, strict=True))[1] in longer
    assert reach.sum() == pytest.approx(0)


def trunk(reach, slope):
    """Roll and pitch of a trunk on legs (legs,) that stand on a slope, by a plane through hips."""
    # Hip heights over the slope are the extensions of the legs; a roll to the right raises the
    # left side, and a pitch with the nose down lowers the front.
    columns = np.column_stack([FEET[:, 1], -FEET[:, 0], np.ones(len(FEET))])
    return slope + np.linalg.lstsq(columns, reach, rcond=None)[0][:2]


def settle(reflex, slope, seconds=20.0):
    """Return the tilt of the trunk, which follows the legs within 0.1 s, and the lengths."""
    tilt, state = slope.copy(), start(reflex)
    for _ in range(round(seconds / INTERVAL)):
        reach = step(reflex, observation(orientation=[[*tilt, 0.0]]), state).reach[0]
        tilt += (trunk(reach, slope) - tilt) * INTERVAL / 0.1
    return tilt, reach


SLOPE = np.array([0.06, -0.04])


def test_a_gain_divides_the_slope():
    for gain in (0.5, 2.0):
        tilt, _ = settle(Level(**{**P_ONLY, "gain": gain}), SLOPE)
        assert tilt == pytest.approx(SLOPE / (1 + gain), rel=1e-6)


def test_the_integral_levels_the_trunk_up_to_the_limit():
    tilt, reach = settle(Level(pitch=1.0, integral_gain=1.0, limit=0.15), SLOPE)
    assert np.abs(tilt).max() < 1e-6
    assert trunk(reach, SLOPE) == pytest.approx([0, 0], abs=1e-6)
    tilt, reach = settle(Level(pitch=1.0, integral_gain=1.0, limit=0.01), SLOPE)
    assert np.abs(reach).max() == pytest.approx(0.01 * LEGS.length)
    assert np.hypot(*tilt) > 0.5 * np.hypot(*SLOPE)


def test_damping_opposes_the_speed():
    seen = observation(rates=[[0.5, 0.0, 9.0]])
    reach = step(Level(gain=0.0, integral_gain=0.0, damping=0.1, limit=0.5), seen).reach[0]
    assert reach == pytest.approx(-0.1 * 0.5 * FEET[:, 1])


def test_a_share_of_the_pitch_counts():
    seen = observation(orientation=[[0.0, 0.1, 0.0]], rates=[[0.0, 0.1, 0.0]])
    assert (step(Level(pitch=0.0), seen).reach == 0).all()
    full, half = (step(Level(pitch=share, limit=0.5), seen).reach for share in (1.0, 0.5))
    assert half == pytest.approx(full / 2)
