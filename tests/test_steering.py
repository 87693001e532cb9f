"""Steered bodies: their controllers, and their movement over time."""

from dataclasses import replace

import numpy as np
import pytest
from kite import COMMANDS, CONTROLLERS, fly_kites

from gaitsim.contracts import Motion
from gaitsim.errors import ContractError, GaitsimError
from gaitsim.steering import Drive, controllers_of


@pytest.fixture
def kite(puppet, puppets, monkeypatch):
    """Return an experiment with a kite."""
    fly_kites(monkeypatch, puppets.Puppet)
    return puppet()


def test_a_body_without_commands_is_rejected_with_alternatives(puppet):
    with pytest.raises(GaitsimError, match="'puppet' cannot be steered"):
        controllers_of(puppet(), {})


def test_controllers_come_with_the_body_or_from_runs(kite, puppet_run):
    assert [*controllers_of(kite, {})] == ["stay", "rise", "sink"]
    path = puppet_run().path
    found = controllers_of(kite, {"rise": str(path)})
    assert found["rise"].shape == (3,)
    with pytest.raises(GaitsimError, match="no steering command 'dive'") as error:
        controllers_of(kite, {"dive": str(path)})
    assert error.value.allowed == "stay, rise, sink"


def test_missing_and_unsuitable_controllers_are_reported(kite, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Puppet, "controllers", lambda self: {"stay": np.zeros(3)})
    with pytest.raises(GaitsimError, match="no controller for the command 'rise'"):
        controllers_of(kite, {})


def test_a_flight_follows_the_clock_frame_by_frame_and_the_commands(kite):
    drive = Drive(kite, controllers_of(kite, {}))
    assert drive.command is COMMANDS[0]
    drive.choose("rise")
    for seconds in (0.104, 0.2, 0.2, 0.55):
        drive.advance_to(seconds)
        assert 0 <= seconds - drive.seconds < 0.01 + 1e-9
    assert drive.altitude == pytest.approx(1 + 0.54)
    assert drive.velocity[2] == pytest.approx(1.0)
    assert drive.shares.tolist() == [0, 1, 0]
    assert len(drive.skeleton.segments) == 55
    assert drive.turned == 0.0


def test_the_ground_and_failures_end_a_flight_and_restart_starts_a_new_one(kite):
    drive = Drive(kite, controllers_of(kite, {}))
    drive.choose("sink")
    for seconds in range(4):
        drive.advance_to(seconds)
    assert drive.seconds == pytest.approx(1.01, abs=0.02)
    assert "hit the ground after 1.0 s" in drive.ending
    drive.restart()
    assert (drive.ending, drive.altitude, drive.command) == ("", 1.0, COMMANDS[0])
    drive.choose("rise")
    for seconds in range(7):
        drive.advance_to(seconds)
    assert "the kite tore" in drive.ending


@pytest.mark.parametrize(
    ("method", "given", "says"),
    [
        ("commands", ("rise",), r"returned \('rise',\) from commands\(\)"),
        ("commands", (COMMANDS[0], replace(COMMANDS[0], key="up")), "with the same name"),
        ("commands", (COMMANDS[0], replace(COMMANDS[1], key="down")), "with the same key"),
        ("steer", None, "returned a NoneType from steer"),
    ],
)
def test_commands_and_bodies_of_other_types_are_reported(
    kite, puppets, monkeypatch, method, given, says
):
    monkeypatch.setattr(puppets.Puppet, method, lambda self, *_: given)
    with pytest.raises(ContractError, match=says):
        Drive(kite, CONTROLLERS)


@pytest.mark.parametrize(
    ("height", "shares", "says"),
    [
        (np.ones((1, 1)), np.ones((1, 1, 3)), "advanced 1 frames instead of 50"),
        (np.full((1, 50), np.nan), np.ones((1, 50, 3)), "not finite"),
        (np.ones((1, 50)), np.ones((1, 50, 2)), r"shares of shape \(1, 50, 2\)"),
    ],
)
def test_a_body_that_breaks_its_contract_is_reported_with_its_package(
    kite, monkeypatch, height, shares, says
):
    given = Motion(100.0, {"height": height, "shares": shares})
    drive = Drive(kite, controllers_of(kite, {}))
    monkeypatch.setattr(drive._steered, "advance", lambda command, frames: given)
    with pytest.raises(ContractError, match=says):
        drive.advance_to(0.51)
