"""Reflexes help robots in physics, with hand-made gaits and in worlds that disturb them."""

import numpy as np
import pytest

from gaitsim.registry import load_class

NONE = {"heading": {"gain": 0.0, "integral_gain": 0.0}}


def walk(reflexes, world):
    """Return the motion of a trot made by hand."""
    body = load_class("organism", "robot")(
        model="quadruped",
        symmetry="alternating",
        servo="sts3215",
        sensors=("mpu6050", "contacts"),
        reflexes=reflexes,
        world=world,
        duration=6.0,
    )
    return body.move(np.array([*body.starts().values()][:1]))


@pytest.mark.slow
def test_heading_keeps_a_robot_on_course():
    world = {"slope": 6.0}
    free, held = (walk(reflexes, world) for reflexes in (NONE, {"heading": {}}))
    (turned,), (kept,) = (np.abs(np.degrees(one["orientation"][:, -1, 2])) for one in (free, held))
    assert turned > 15
    assert kept < 8
    assert held["torso"][0, -1, 0] > free["torso"][0, -1, 0]


@pytest.mark.slow
def test_contact_helps_over_rubble():
    distances = {
        name: [
            walk(reflexes, {"rubble": 0.02, "seed": seed})["torso"][0, -1, 0] for seed in range(4)
        ]
        for name, reflexes in {"without": NONE, "with": {"contact": {}}}.items()
    }
    assert np.mean(distances["with"]) > 1.5 * np.mean(distances["without"])
