"""The fitness `travel`: its terms, and its use with any dynamic body."""

import numpy as np
import pytest
from walking_motion import (
    FRAMES,
    LENGTH,
    STALL,
    TIME,
    WEIGHT,
    motion,
    straight,
)

from gaitsim_robot.travel import TravelFitness


def sine(amplitude, frequency):
    return amplitude * np.sin(2 * np.pi * frequency * np.tile(TIME[:, None], 4))


YAW = np.zeros((FRAMES, 3))
YAW[:, 2] = 0.5 * TIME / TIME[-1]  # 0.5 rad at the end: a root mean square of 0.5/√3


@pytest.mark.parametrize(
    ("term", "options", "changed", "expected"),
    [
        ("forward", {}, {"torso": straight(3.0)}, 3.0),
        ("forward", {"direction": 90}, {"torso": straight(0, 3.0)}, 3.0),
        ("forward", {"direction": -180}, {"torso": straight(-3.0)}, 3.0),
        ("forward", {"direction": -45}, {"torso": straight(2.0, -2.0)}, np.sqrt(8)),
        ("drift", {"direction": 90}, {"torso": straight(2.0)}, -1.0),
        ("turn", {}, {"orientation": YAW}, -2 * LENGTH * 0.5 / np.sqrt(3)),
        ("fall", {}, {"lasted": np.array(0.0)}, -20 * LENGTH),
        ("fall", {}, {"lasted": np.array(5.0)}, -15 * LENGTH),
        ("fall", {}, {"lasted": np.array(9.98)}, -20 * LENGTH * 0.501),
        ("energy", {}, {"energy": 60 * TIME / TIME[-1]}, -0.1 * 60 / WEIGHT),
        ("torque", {}, {"torque": np.full((FRAMES, 4), 0.8 * STALL)}, -10 * LENGTH * 0.3),
        ("torque", {}, {"torque": np.full((FRAMES, 4), 0.5 * STALL)}, 0.0),
        ("roughness", {}, {"joint_positions": sine(0.1, 15)}, -20 * LENGTH * 0.1 / np.sqrt(2)),
        ("roughness", {}, {"joint_positions": 1.0 + sine(0.0, 1)}, 0.0),
        ("slip", {}, {"slip": np.full(FRAMES, 0.01)}, -0.5 * 5.01),
    ],
)
def test_each_term_follows_its_definition_and_does_not_affect_others(
    term, options, changed, expected
):
    terms = TravelFitness(**options).terms(motion(**changed))
    assert float(terms.pop(term)[0]) == pytest.approx(expected, rel=1e-2, abs=1e-9)
    assert {name: float(v[0]) for name, v in terms.items()} == pytest.approx(
        dict.fromkeys(terms, 0.0), abs=1e-9
    )


def test_a_gait_of_one_hertz_is_hardly_rough():
    """A fourth-order Butterworth filter has the gain 1/√(1 + 5⁸) = 0.0016 at 1/5 of its cutoff."""
    terms = TravelFitness().terms(motion(joint_positions=sine(0.5, 1.0)))
    assert -0.02 < float(terms["roughness"][0]) < 0


def test_distance_beyond_the_target_speed_does_not_pay():
    """A robot at 0.2 m/s covers 2 m in 10 s."""
    scores = {
        x: sum(
            v[0] for v in TravelFitness(target_speed=0.2).terms(motion(torso=straight(x))).values()
        )
        for x in (1.5, 2.0, 3.0)
    }
    assert scores == pytest.approx({1.5: 1.5, 2.0: 2.0, 3.0: 1.0})


def test_unknown_quantities_are_not_penalised():
    loaded = {"torque": np.full((FRAMES, 4), 9.0), "energy": 60 * TIME}
    unknown = {"stall_torque": np.zeros(4), "weight": np.array(0.0)}
    terms = TravelFitness().terms(motion(**loaded, **unknown))
    assert terms["torque"] == terms["energy"] == 0
