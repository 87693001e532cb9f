"""Commands, and bodies that nobody can steer."""

import pytest

from gaitsim.choices import STEERING_KEYS
from gaitsim.contracts import Command
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.tui.keys import ACTIONS


def test_a_command_has_a_name_and_a_key():
    assert Command("climb", "space", "rises").key == "space"
    with pytest.raises(ValueError, match="up, down, left, right, space"):
        Command("climb", "r", "rises")
    with pytest.raises(ValueError, match="name"):
        Command("", "up", "rises")


def test_a_body_without_commands_cannot_be_steered():
    body = load_experiment("walker").organism
    assert not body.commands()
    assert not body.controllers()
    assert not body.controller_names()
    with pytest.raises(GaitsimError, match="Walker"):
        body.steer({})


def test_the_keys_of_commands_have_no_other_action_on_the_steering_screen():
    own = {"steering", "screen", "app"}
    taken = {
        key
        for group in own
        for action in ACTIONS[group]
        if action.do != f"command({action.name!r})"
        for key in action.keys.split(",")
    }
    assert not taken & {*STEERING_KEYS}
