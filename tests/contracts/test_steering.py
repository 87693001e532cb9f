"""Commands, and bodies that nobody can steer."""

import pytest

from gaitsim.contracts import Command
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment


def test_a_command_has_a_name_and_a_key():
    assert Command("climb", "space", "rises").key == "space"
    with pytest.raises(ValueError, match="up, down, left, right, space"):
        Command("climb", "x", "rises")
    with pytest.raises(ValueError, match="name"):
        Command("", "up", "rises")


def test_a_body_without_commands_cannot_be_steered():
    body = load_experiment("walker").organism
    assert not body.commands()
    assert not body.controllers()
    assert body.steering_page({}) is None
    with pytest.raises(GaitsimError, match="Walker"):
        body.steer({})
