"""Errors of `gaitsim steer`."""

import pytest


@pytest.fixture
def terminal(monkeypatch):
    """Let gaitsim run as in a terminal."""
    monkeypatch.setenv("TEXTUAL_DRIVER", "textual.drivers.headless_driver:HeadlessDriver")


def test_steering_needs_a_terminal(gaitsim):
    assert "needs a terminal" in gaitsim("steer", code=2).stderr


def test_a_body_without_commands_is_rejected_with_alternatives(gaitsim, terminal):
    said = gaitsim("steer", "spider", code=2).stderr
    assert "'spider' cannot be steered" in said
    assert "a body with steering commands" in said


def test_an_invalid_controller_is_rejected(gaitsim, terminal):
    said = gaitsim("steer", "fly", "--controller", "climb", code=2).stderr
    assert "invalid controller: 'climb'" in said
    assert "COMMAND=RUN" in said
