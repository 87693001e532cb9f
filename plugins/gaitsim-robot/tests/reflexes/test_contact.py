"""The reflex `contact` extends legs over holes and retracts them over bumps."""

import numpy as np
import pytest
from bench import INTERVAL, LEGS, observation, start, step

from gaitsim_reflexes.contact import Contact

LENGTH = LEGS.length
REFLEX = Contact(extension=1.0, retraction=0.5, limit=0.1, hurry=2.0)
STEP = LENGTH * INTERVAL  # of an extension in a control step
LATE, LOW, LIFTING, EARLY = 0.1, 0.4, 0.6, 0.9  # phases; duty is 0.5


def feel(state, phases, contacts, steps=1, **parts):
    seen = observation(phase=[phases], contacts=[contacts], **parts)
    for _ in range(steps):
        inputs = step(REFLEX, seen, state)
    return inputs


def test_a_foot_over_a_hole_is_extended_until_it_lands():
    state = start(REFLEX)
    feel(state, [LATE, LATE, LOW, LIFTING], [0, 1, 0, 0], steps=3)
    assert state["change"][0] == pytest.approx([3 * STEP, 0, 0, 0])
    inputs = feel(state, [LATE, LOW, LOW, LIFTING], [1, 1, 1, 0], steps=3)
    assert inputs.reach[0] == pytest.approx([3 * STEP, 0, 0, 0])  # kept in stance
    assert (inputs.rate == 1).all()
    inputs = feel(state, [LIFTING] * 4, [0] * 4, steps=2)
    assert inputs.reach[0] == pytest.approx([STEP, 0, 0, 0])  # lost in swing
    assert feel(state, [LIFTING] * 4, [0] * 4, steps=2).reach[0] == pytest.approx([0] * 4)


def test_a_foot_on_a_bump_is_retracted_and_its_swing_is_short():
    state = start(REFLEX)
    inputs = feel(state, [EARLY, LIFTING, EARLY, LOW], [1, 1, 0, 1], steps=2)
    assert inputs.rate[0] == pytest.approx([2, 1, 1, 1])
    assert inputs.reach[0] == pytest.approx([-STEP, 0, 0, 0])
    inputs = feel(state, [LATE, LATE, LATE, LATE], [1] * 4)
    assert inputs.reach[0] == pytest.approx([-STEP, 0, 0, 0])


def test_the_change_is_limited():
    state = start(REFLEX)
    feel(state, [LATE, EARLY, LOW, LOW], [0, 1, 1, 1], steps=100)
    assert state["change"][0] == pytest.approx([0.1 * LENGTH, -0.1 * LENGTH, 0, 0])


def test_standing_changes_nothing():
    state = start(REFLEX)
    feel(state, [LATE] * 4, [0, 1, 1, 1])
    before = state["change"].copy()
    inputs = feel(state, [LATE, EARLY, LIFTING, LIFTING], [0, 1, 0, 1], command=np.zeros((1, 4)))
    assert (state["change"] == before).all()
    assert (inputs.reach == before).all()
    assert (inputs.rate == 1).all()
