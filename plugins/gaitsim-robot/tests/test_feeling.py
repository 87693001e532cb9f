"""Robots that feel: lock step against tapes, reflexes, drives, sensors, and the same bits."""

import numpy as np
import pytest

from gaitsim_robot.feeling import HOLD, Truth
from gaitsim_robot.organism import Robot

HORNS = {"joint_offset": 2.0, "seed": 0.0}
OFF = {"gain": 0.0, "integral_gain": 0.0}


def robot(model="hexapod", **options):
    return Robot(model=model, symmetry="alternating", servo="sts3215", **options)


def start(body, count=1):
    return np.tile(next(iter(body.starts().values())), (count, 1))


def turned(motion):
    """Return the RMS yaw, (population,) °."""
    return np.degrees(np.sqrt(np.square(motion["orientation"][..., 2]).mean(axis=1)))


def walkers(body, count):
    """Return genomes around the start, the last of which falls."""
    space = body.genome_space()
    spread = 0.1 * np.random.default_rng(3).standard_normal((count, space.genes))
    return np.clip(
        start(body, count) + spread * (space.upper - space.lower), space.lower, space.upper
    )


def test_without_gains_a_robot_walks_as_its_tape():
    felt, tape = robot(duration=4, reflexes={"heading": OFF}), robot(duration=4)
    moved = felt.move(start(felt))["torso"][0, -1, :2]
    np.testing.assert_allclose(moved, tape.move(start(tape))["torso"][0, -1, :2], atol=0.05)


def test_heading_keeps_the_direction_with_horn_errors():
    tape, felt = (
        robot(duration=6, world=HORNS, reflexes=reflexes) for reflexes in ({}, {"heading": {}})
    )
    assert turned(tape.move(start(tape)))[0] > 15
    assert turned(felt.move(start(felt)))[0] < 5


def test_evolved_options_and_weights_are_genes():
    plain = robot(duration=1, reflexes={"heading": {"gain": 6.0}})
    evolved = robot(duration=1, reflexes={"heading": {}, "network": {}}, evolve=["heading.gain"])
    own, space = start(evolved)[0], evolved.genome_space()
    genes = plain.genome_space().genes
    assert space.labels[genes] == "heading gain"
    assert (space.lower[genes], space.upper[genes]) == (0, 50)
    assert own[genes] == 4.0
    assert not own[genes + 1 :].any()  # weights of 0 change nothing
    own[genes] = 6.0
    np.testing.assert_array_equal(
        evolved.move(own[None])["torso"], plain.move(own[None, :genes])["torso"]
    )


@pytest.mark.slow
def test_drives_are_obeyed():
    body = robot(reflexes={"heading": {}}, duration=8)
    drive = [{"speed": 0.2}, {"at": 4, "speed": 0.0, "turn": 30.0}, {"at": 7, "turn": 0.0}]
    gait = start(body)
    body = body.calibrated(gait[0])
    body = Robot.model_validate({**body.model_dump(), "drive": drive})
    motion = body.move(gait)
    ahead, yaw = motion["torso"][0, :, 0], np.degrees(motion["orientation"][0, :, 2])
    assert ahead[200] - ahead[50] == pytest.approx(3 * 0.2, rel=0.15)
    assert yaw[-1] == pytest.approx(90, abs=10)
    assert np.degrees(motion["commanded_heading"][0, -1]) == pytest.approx(90, abs=5)
    assert np.abs(motion["joint_angles"][0, -1] - body.standing_pose()).max() < 0.01


def test_a_drive_pushes_when_it_says():
    body = robot(duration=2, drive=[{"at": 1.0, "push": 0.5, "direction": 90.0}])
    speed = body.move(start(body))["torso_velocity"][0, :, 1]
    assert np.abs(speed[:50]).max() < 0.05
    assert speed[50:53].max() > 0.2


def test_invalid_measurements_are_held_and_then_stop_the_robot():
    body = robot(reflexes={"heading": {}})
    pilot = body.pilot(start(body))
    target = np.array([[pilot.rhythm.own_speed[0], 0.0, 0.0, 0.0]])
    truth = Truth(
        np.array([[0.0, 0.0, 0.3]]), np.zeros((1, 3)), np.full((1, 6), 0.2), np.zeros((1, 18))
    )
    for frame in range(50):
        pilot.step(frame, target, truth)
    valid = pilot.seen.orientation[0, 2]
    assert valid == pytest.approx(0.3, abs=0.05)
    truth.orientation[0, 2] = np.nan
    for frame in range(50, 52 + round(HOLD * 50)):
        assert np.isfinite(pilot.step(frame, target, truth)).all()
        assert pilot.seen.orientation[0, 2] == pytest.approx(valid, abs=0.01)
    for frame in range(62, 122):
        angles = pilot.step(frame, target, truth)
    np.testing.assert_allclose(angles[0], body.standing_pose(), atol=0.01)


def test_channels_exist_only_for_robots_that_feel():
    assert "command" in Robot.channels
    tape, felt = robot(duration=1), robot(duration=1, reflexes={"heading": {}})
    for body in (tape, felt):
        assert {*body.channels} == {*body.move(start(body))}
    assert "command" not in tape.channels


def test_bullet_feels_too():
    pytest.importorskip("pybullet")
    felt, tape = (
        robot(duration=4, engine="bullet", world=HORNS, reflexes=reflexes)
        for reflexes in ({"heading": {}}, {})
    )
    genomes = np.concatenate([start(felt), walkers(felt, 1)])
    motion = felt.move(genomes)
    assert turned(motion)[0] < 0.4 * turned(tape.move(genomes))[0]
    np.testing.assert_array_equal(felt.move(genomes[1:])["torso"][0], motion["torso"][1])


def test_a_slope_is_felt_as_tilt():
    world = {"slope": 6.0, "side_slope": -4.0}
    body = robot(duration=0.5, world=world, sensors=["ideal"], reflexes={"heading": OFF})
    felt = np.degrees(body.move(start(body))["measured_orientation"][0, 0])
    np.testing.assert_allclose(felt, [-4.0, -6.0, 0.0], atol=0.3)
