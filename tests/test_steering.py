"""Steered bodies: their controllers, and their movement over time."""

from dataclasses import replace

import numpy as np
import pytest
from kite import COMMANDS, CONTROLLERS, fly_kites

from gaitsim import steering
from gaitsim.api import evolve, load
from gaitsim.contracts import Motion
from gaitsim.errors import ContractError, GaitsimError
from gaitsim.experiment import with_overrides
from gaitsim.individual import Individual
from gaitsim.steering import (
    SteeredDrive,
    controllers_of,
    create_drive,
    individual_controllers,
    individual_drive,
)


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
    with pytest.raises(GaitsimError, match="no controller 'dive'") as error:
        controllers_of(kite, {"dive": str(path)})
    assert error.value.allowed == "stay, rise, sink"


def test_a_flight_follows_the_clock_frame_by_frame_and_the_commands(kite):
    drive = SteeredDrive(kite, controllers_of(kite, {}))
    assert drive.command is COMMANDS[0]
    drive.give("rise")
    for seconds in (0.104, 0.2, 0.2, 0.55):
        drive.advance_to(seconds)
        assert 0 <= seconds - drive.seconds < 0.01 + 1e-9
    assert drive.altitude == pytest.approx(1 + 0.54)
    assert drive.velocity[2] == pytest.approx(1.0)
    assert drive.shares.tolist() == [0, 1, 0]
    assert len(drive.skeleton.segments) == 55
    assert drive.turned == 0.0


def test_the_ground_and_failures_end_a_flight_and_restart_starts_a_new_one(kite):
    drive = SteeredDrive(kite, controllers_of(kite, {}))
    drive.give("sink")
    for seconds in range(4):
        drive.advance_to(seconds)
    assert drive.seconds == pytest.approx(1.01, abs=0.02)
    assert "hit the ground after 1.0 s" in drive.ending
    drive.restart()
    assert (drive.ending, drive.altitude, drive.command) == ("", 1.0, COMMANDS[0])
    drive.give("rise")
    for seconds in range(7):
        drive.advance_to(seconds)
    assert "the kite tore" in drive.ending


@pytest.mark.parametrize(
    ("method", "given", "says"),
    [
        ("commands", ("rise",), r"returned \('rise',\) from commands\(\)"),
        ("commands", (COMMANDS[0], replace(COMMANDS[0], key="up")), "with the same name"),
        ("steer", None, "returned a NoneType from steer"),
    ],
)
def test_commands_and_bodies_of_other_types_are_reported(
    kite, puppets, monkeypatch, method, given, says
):
    monkeypatch.setattr(puppets.Puppet, method, lambda self, *_: given)
    with pytest.raises(ContractError, match=says):
        SteeredDrive(kite, CONTROLLERS)


@pytest.mark.parametrize(
    ("height", "shares", "says"),
    [
        (np.ones((1, 1)), np.ones((1, 1, 3)), "advanced 1 frames instead of 50"),
        (np.ones((1, 50)), np.ones((1, 50, 2)), r"shares of shape \(1, 50, 2\)"),
    ],
)
def test_a_body_that_breaks_its_contract_is_reported_with_its_package(
    kite, monkeypatch, height, shares, says
):
    given = Motion(100.0, {"height": height, "shares": shares})
    drive = SteeredDrive(kite, controllers_of(kite, {}))
    monkeypatch.setattr(drive._steered, "advance", lambda frames: given)
    with pytest.raises(ContractError, match=says):
        drive.advance_to(0.51)


def driven(cart):
    """Return a drive of a cart around two bends, of 1.9 s."""
    drive = create_drive(cart, {})
    for seconds, commands in ((0.5, ("faster", "faster")), (1.1, ("left",)), (1.9, ("right",))):
        for command in commands:
            drive.give(command)
        drive.advance_to(seconds)
    return drive


def test_a_walking_body_reports_what_it_is_asked_to_do(cart):
    drive = create_drive(cart, {})
    assert not drive.holds
    assert not drive.flies
    assert drive.shares is None
    assert drive.notice == ""
    for _ in range(5):
        drive.give("faster")
    drive.advance_to(1.0)
    assert drive.facts["wish"] == "0.30 m/s"
    assert drive.notice == "The speed is clipped to 0.3 m/s."
    shown = drive.skeleton
    assert shown.contacts.shape == (len(shown.segments), 2, 3)
    assert shown.ground is not None
    assert "cart fell" not in drive.ending


def test_a_saved_drive_is_a_run_whose_champion_repeats_it_bit_for_bit(cart, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    drive = driven(cart)
    path = drive.save()
    assert drive.saved == path
    assert path.name == "cart-drive"
    run = load(path)
    champion = run.champion
    assert champion.score == pytest.approx(np.hypot(*drive.path[-1, :2]), abs=0.01)
    assert np.array_equal(champion.skeleton.path[-1], drive.path[-1])
    assert len(champion.skeleton.path) == round(drive.seconds * 50)
    assert run.snapshot.stop_reason
    # The drive of a saved drive keeps its name.
    again = individual_drive(str(path))
    again.give("faster")
    again.advance_to(0.5)
    assert again.save().name == "cart-drive-2"
    drive.give("stop")
    drive.advance_to(2.0)
    assert drive.saved is None


def test_bodies_that_cannot_repeat_a_drive_are_reported(kite, cart, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    drive = create_drive(kite, {})
    assert not drive.recordable
    with pytest.raises(GaitsimError, match="drives of the body 'puppet' cannot be recorded"):
        drive.save()
    with pytest.raises(GaitsimError, match="needs a controller for each command"):
        individual_controllers(kite, np.zeros(3), "runs/kite")
    monkeypatch.setattr(type(drive._steered), "drive", lambda self: {"load": 1.0})
    with pytest.raises(ContractError, match="records a drive with 3 controllers"):
        drive.save()
    slippery = driven(with_overrides(cart, {"organism.slippery": True}))
    with pytest.raises(GaitsimError, match="cannot repeat the drive: it slips"):
        slippery.save()
    assert not [*tmp_path.glob("runs/*")]


def test_a_champion_is_driven_in_python(cart, tmp_path):
    for _ in evolve(cart, out=tmp_path / "cart", seed=1):
        pass
    run = load(tmp_path / "cart")
    drive = [{"at": 0, "speed": 0.1, "turn": 0}, {"at": np.float32(1), "speed": 0, "turn": 0.5}]
    champion = run.replay(drive=drive)
    organism = champion.experiment.organism
    assert organism.drive == drive
    assert organism.duration == 3.0
    expected = organism.move(run.champion.genome[None])
    assert np.array_equal(champion.motion["place"], expected["place"])
    assert champion.score == champion.replayed_score
    assert "drive [{at = 0.0, speed = 0.1, " in champion.label
    # A recorded drive is such a list, too.
    recorded = driven(cart)
    path = recorded.save(tmp_path / "recorded")
    again = run.replay(drive=load(path).experiment.organism.drive)
    assert len(again.experiment.organism.drive) == len(load(path).experiment.organism.drive) > 3


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        (3, "not a drive: 3"),
        ([{"at": "soon"}], "not a drive"),
    ],
)
def test_invalid_drives_are_refused(cart, drive, says):
    genome = cart.organism.starts()["slow"]
    with pytest.raises(GaitsimError, match=says):
        steering.driven(Individual(cart, 0.0, {}, 1, genome), drive)
