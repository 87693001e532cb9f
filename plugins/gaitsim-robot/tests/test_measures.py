"""Measures of robots, for motions with known measures."""

import numpy as np
import pytest

from gaitsim.contracts import Motion
from gaitsim_robot.anatomy import Leg
from gaitsim_robot.measures import measures

RATE, FRAMES = 50.0, 101  # 2 s
LEGS = [Leg(f"{side[0].upper()}1", side, (), "foot", (0, 0, 0)) for side in ("left", "right")]
TIME = np.arange(FRAMES) / RATE


def measured(**changed):
    """Return the measures of a robot at rest, with some channels replaced."""
    channels = {
        "torso": np.zeros((FRAMES, 3)),
        "orientation": np.zeros((FRAMES, 3)),
        "height": np.full(FRAMES, 0.2),
        "torque": np.zeros((FRAMES, 2)),
        "stall_torque": np.array([2.0, 4.0]),
        "rms_torque": np.array([0.5, 1.2]),
        "continuous_torque": np.array([0.25, 0.0]),
        "stride_frequency": np.array(0.0),
        "energy": np.zeros(FRAMES),
        "slip": np.zeros(FRAMES),
        "stance": np.ones((FRAMES, 2), dtype=bool),
        "lasted": np.array(2.0),
        "weight": np.array(20.0),
        "length": np.array(0.3),
    }
    both = {
        name: np.stack([values, changed.get(name, values)]) for name, values in channels.items()
    }
    found = measures(Motion(RATE, both), LEGS)
    return {name: float(measure.values[1]) for name, measure in found.items()}


def until_one_second(before, after):
    return np.where(TIME <= 1.0, before, after)


WALK = TIME[:, None] * np.array([0.3, -0.4, 0.0])  # 0.5 m/s; 1 m in 2 s
TIPPED = np.zeros((FRAMES, 3))
TIPPED[:, 0], TIPPED[:, 1], TIPPED[:, 2] = np.pi / 3, np.pi / 3, TIME


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"torso": WALK}, {"forward": 0.6, "lateral": -0.8, "body lengths": 1 / 0.3, "speed": 0.5}),
        (
            {"torso": WALK, "energy": 20 * TIME, "slip": np.full(FRAMES, 0.2 / FRAMES)},
            {"cost of transport": 2.0, "mean power": 20.0, "slip ratio": 0.2},
        ),
        (
            {"torque": np.outer(TIME, [0.8, 0.9])},
            {"peak torque": 0.8, "RMS torque": 0.3, "heat": 2.0},
        ),
        # Two rotations of 60° result in a tilt whose cosine is 1/4.
        ({"orientation": TIPPED}, {"tilt": np.degrees(np.arccos(0.25)), "yaw": np.degrees(2)}),
        (
            {
                "lasted": np.array(1.0),
                "height": until_one_second(0.2, 0.05),
                "stance": np.stack([TIME <= 1.0, TIME < 0], axis=1),
                "torso": np.minimum(WALK, WALK[50]),
                "energy": np.minimum(20 * TIME, 20),
            },
            {"lasted": 1.0, "body height": 0.2, "duty factor": 0.5, "mean power": 20.0},
        ),
        ({}, {"cost of transport": np.inf, "slip ratio": np.inf, "speed": 0.0}),
        ({"lasted": np.array(0.0)}, {"speed": 0.0, "mean power": 0.0, "body height": 0.2}),
    ],
)
def test_measures_follow_their_definitions(changed, expected):
    found = measured(**changed)
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-9)
