"""`gaitsim steer`: what it says where nothing can be steered."""

import pytest


@pytest.fixture
def terminal(monkeypatch):
    """Let gaitsim run as in a terminal."""
    monkeypatch.setenv("TEXTUAL_DRIVER", "textual.drivers.headless_driver:HeadlessDriver")


def test_it_needs_a_terminal(gaitsim):
    assert "needs a terminal" in gaitsim("steer", code=2).stderr


def test_a_body_without_commands_is_refused_and_others_are_named(gaitsim, terminal):
    said = gaitsim("steer", "spider", code=2).stderr
    assert "'spider' cannot be steered" in said
    assert "a body with commands" in said


def test_a_controller_is_a_command_and_an_individual(gaitsim, terminal):
    said = gaitsim("steer", "fly", "--controller", "climb", code=2).stderr
    assert "'climb' is not a controller" in said
    assert "COMMAND=RUN" in said
