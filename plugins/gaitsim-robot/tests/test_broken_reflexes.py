"""Reflexes that break their contract end in one message that names them, or fail individuals."""

import numpy as np
import pytest

from gaitsim.errors import ContractError
from gaitsim_reflexes.heading import Heading
from gaitsim_robot.organism import Robot

ROBOT = Robot(model="quadruped", duration=1.0, reflexes={"heading": {}})
GENOMES = np.tile(next(iter(ROBOT.starts().values())), (3, 1))


def raises(state, seen, inputs):
    raise KeyError("a bug")


def leaves(state, seen, inputs):
    raise SystemExit(3)


def shortens(state, seen, inputs):
    inputs.stride = np.ones((1, 1))


def converts(state, seen, inputs):
    inputs.reach = inputs.reach.astype(np.float32)


def adds_a_state(state, seen, inputs):
    state["new"] = np.ones(3)


def changes_what_is_seen(state, seen, inputs):
    seen.command[:] = 0.0


@pytest.mark.parametrize(
    "step", [raises, leaves, shortens, converts, adds_a_state, changes_what_is_seen]
)
def test_a_broken_step_is_an_error_of_the_reflex(monkeypatch, step):
    monkeypatch.setattr(Heading, "step", lambda self, *given: step(*given[:3]))
    with pytest.raises(ContractError, match="reflex 'heading' of package gaitsim") as caught:
        ROBOT.move(GENOMES)
    assert "Heading" in caught.value.where


@pytest.mark.parametrize("state", [None, {"n": 3}, {"n": np.zeros((1, 2))}])
def test_an_invalid_start_is_an_error_of_the_reflex(monkeypatch, state):
    monkeypatch.setattr(Heading, "start", lambda self, legs, weights: state)
    with pytest.raises(ContractError, match=r"'heading'.* invalid state"):
        ROBOT.move(GENOMES)


@pytest.mark.parametrize("count", [-1, 10**9, "seven", None])
def test_an_invalid_number_of_weights_is_an_error_of_the_reflex(monkeypatch, count):
    monkeypatch.setattr(Heading, "weights", lambda self, legs: count)
    with pytest.raises(ContractError, match=r"'heading'.* weights"):
        ROBOT.genome_space()


@pytest.mark.parametrize("part", ["command", "stride", "reach", "rate"])
def test_an_individual_with_an_invalid_input_fails_with_a_reason(monkeypatch, part):
    expected = ROBOT.move(GENOMES)
    whole = Heading.step

    def step(self, state, seen, inputs, interval):
        whole(self, state, seen, inputs, interval)
        if len(inputs.command) == 3 and seen.phase[0, 0] > 0.5:
            getattr(inputs, part)[1] = np.nan

    monkeypatch.setattr(Heading, "step", step)
    motion = ROBOT.move(GENOMES)
    assert list(motion.failures) == [1]
    assert f"the reflex 'heading' made the input '{part}' infinite or NaN" in motion.failures[1]
    np.testing.assert_array_equal(motion["torso"][[0, 2]], expected["torso"][[0, 2]])
