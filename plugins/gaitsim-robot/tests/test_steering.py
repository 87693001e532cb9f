"""Robots that a driver steers: drives that repeat bit for bit, limits, falls and refusals."""

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim_robot.organism import Robot
from gaitsim_robot.steering import COMMANDS, STEPS


def driven(robot, genome, seconds, seed):
    """Return a steered robot and its motions after random commands."""
    steered, rng, motions = robot.steer({"gait": genome}), np.random.default_rng(seed), []
    while sum(one["torso"].shape[1] for one in motions) < 50 * seconds:
        for _ in range(rng.integers(4)):
            steered.give(COMMANDS[rng.integers(len(COMMANDS))].name)
        motion = steered.advance(int(rng.integers(1, 60)))
        motions.append(motion)
        if motion.failures:
            break
    return steered, motions


def repeated(robot, steered, genome):
    """Return the motion of a robot that repeats a drive from its options."""
    again = Robot(**{**robot.model_dump(), **steered.drive()})
    return again.move(genome[None])


def frames_of(robot):
    """Return the names of channels with frames whose values a push does not change afterwards."""
    channels = robot.model_copy(update={"drive": ({"at": 0.0},)}).channels
    framed = {name for name, one in channels.items() if one.axes[:1] == ("frames",)}
    return framed - {"torso_velocity", "energy"}


@pytest.mark.sampled
@pytest.mark.parametrize(
    "options",
    [
        {"model": "hexapod", "symmetry": "alternating", "servo": "sts3215"},
        {
            "model": "hexapod",
            "reflexes": {"heading": {}},
            "world": {"unevenness": 0.01, "joint_offset": 2.0, "push": 0.2, "seed": 3},
        },
        {"model": "quadruped", "latency": 0.03},
        {"model": "spider-physics", "world": {"slope": 5.0, "rubble": 0.01}},
    ],
)
def test_a_drive_repeats_bit_for_bit(options):
    robot = Robot(**options)
    genome = robot.controllers()["gait"]
    steered, motions = driven(robot, genome, 6, 1)
    whole = repeated(robot, steered, genome)
    felt = {"command", "changed_command", "measured_orientation", "commanded_heading"}
    for name in frames_of(robot) - {"orientation"}:
        mine = np.concatenate([one[name] for one in motions], axis=1)
        # What a robot felt and was commanded in a frame moves it to the next one.
        first = 0 if name in felt | {"joint_angles"} else 1
        expected = whole[name][:, first : first + mine.shape[1]]
        assert np.array_equal(expected, mine), name


def test_a_robot_walks_turns_and_stops_as_commanded():
    robot = load_experiment("hexapod").organism
    steered = robot.steer(robot.controllers())
    for _ in range(2):
        steered.give("faster")
    steered.advance(100)
    ahead = steered.advance(100)["torso"][0]
    wanted = float(steered.facts()["set speed"].split()[0])
    assert np.linalg.norm(ahead[-1] - ahead[0]) / 1.98 == pytest.approx(wanted, rel=0.15)
    steered.give("stop")
    steered.give("left")
    steered.advance(100)
    yaw = steered.advance(100)["orientation"][0, :, 2]
    turned = np.degrees(np.unwrap(yaw)[-1] - yaw[0]) / 1.98
    assert turned == pytest.approx(float(steered.facts()["set turn"].split()[0]), rel=0.2)
    steered.give("stop")
    steered.advance(100)
    still = steered.advance(50)["torso"][0]
    assert np.ptp(still[:, :2], axis=0).max() < 0.005


@pytest.mark.slow
def test_commands_beyond_the_limits_are_clipped_and_said():
    robot = Robot(model="hexapod")
    steered = robot.steer(robot.controllers())
    for _ in range(STEPS):
        steered.give("faster")
        assert steered.notice() == ""
    most = steered.facts()["set speed"]
    steered.give("faster")
    assert steered.facts()["set speed"] == most
    assert f"The speed is clipped to {most}" in steered.notice()
    for _ in range(STEPS):
        steered.give("left")
    steered.advance(100)
    assert "too long: clipped to" in steered.notice()
    steered.give("stop")
    steered.advance(100)
    assert steered.notice() == ""


def test_a_fall_ends_a_drive_and_is_repeated():
    robot = Robot(model="quadruped")
    genome = robot.controllers()["gait"]
    steered = robot.steer({"gait": genome})
    failures = {}
    for _ in range(200):
        steered._wheel._pushed = 0  # from the same direction
        steered.give("push")
        failures = steered.advance(1).failures
        if failures:
            break
    assert failures == {0: "the robot fell"}
    last = steered.advance(5)["torso"][0, -1]
    assert np.array_equal(repeated(robot, steered, genome)["torso"][0, -1], last)


def test_wrong_commands_genomes_and_engines_are_refused():
    robot = Robot(model="hexapod")
    with pytest.raises(GaitsimError, match="shape"):
        robot.steer({"gait": np.zeros(3)})
    with pytest.raises(GaitsimError, match="in MuJoCo only"):
        robot.model_copy(update={"engine": "bullet"}).steer(robot.controllers())
    steered = robot.steer(robot.controllers())
    with pytest.raises(GaitsimError, match="unknown command 'fly'"):
        steered.give("fly")
    with pytest.raises(GaitsimError, match="by 0 frames"):
        steered.advance(0)
    with pytest.raises(GaitsimError, match="at most 600 s"):
        steered.advance(30_001)


def test_a_held_stop_key_adds_no_entries():
    robot = Robot(model="quadruped")
    steered = robot.steer(robot.controllers())
    for command in ("stop", "faster", "stop", "stop", "stop"):
        steered.give(command)
    assert [entry["speed"] for entry in steered.drive()["drive"][2:]] == [0.0]
