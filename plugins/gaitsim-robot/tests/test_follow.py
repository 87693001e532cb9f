"""The fitness `follow`, against closed forms."""

import numpy as np
import pytest
from walking_motion import (
    FRAMES,
    LENGTH,
    TIME,
    WEIGHT,
    motion,
    straight,
)

from gaitsim.errors import ExperimentError
from gaitsim.experiment import load_experiment
from gaitsim_robot.follow import FollowFitness


def commands(speed=0.0, turn=0.0, sideways=0.0, height=0.0):
    """Return commands, each a number or an array (frames,)."""
    return np.stack([np.broadcast_to(one, FRAMES) for one in (speed, turn, sideways, height)], -1)


def turned(yaw):
    """Return an orientation with yaw (frames,)."""
    return np.stack([np.zeros(FRAMES), np.zeros(FRAMES), yaw], axis=-1)


def circle(speed, sideways, turn, start=0.0):
    """Return torso and orientation of a robot that follows constant commands exactly."""
    yaw = start + turn * TIME
    along, across = (np.sin(yaw) - np.sin(start)) / turn, (np.cos(start) - np.cos(yaw)) / turn
    x, y = speed * along - sideways * across, speed * across + sideways * along
    return {"torso": np.stack([x, y, 0 * x], axis=-1), "orientation": turned(yaw)}


def terms(fitness=None, **changed):
    found = (fitness or FollowFitness()).terms(motion(**changed))
    return {name: float(values[0]) for name, values in found.items()}


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0, -1.0])
@pytest.mark.parametrize(("speed", "sideways"), [(0.2, 0.0), (-0.2, 0.0), (0.12, -0.16)])
def test_a_robot_gets_the_share_of_the_commanded_distance_that_it_walks(share, speed, sideways):
    moved = straight(10 * share * speed, 10 * share * sideways)
    found = terms(command=commands(speed, sideways=sideways), torso=moved)
    assert found["commanded"] == pytest.approx(2.0)
    assert sum(found.values()) == pytest.approx(2.0 * share)


@pytest.mark.parametrize("turn", [0.5, -0.3])
def test_a_robot_on_the_commanded_circle_has_no_error(turn):
    exact = circle(0.2, 0.05, turn, start=0.4)
    found = terms(command=commands(0.2, turn, 0.05), **exact)
    assert found.pop("commanded") == pytest.approx(10 * np.hypot(0.2, 0.05))
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-4)
    mirrored = circle(0.2, 0.05, -turn, start=0.4)
    wrong = terms(command=commands(0.2, turn, 0.05), **mirrored)
    assert wrong["path"] < -0.1
    assert wrong["heading"] < -0.5


def test_turns_on_the_spot_count_as_heading():
    """A robot that does not turn at all has an RMS error of ωT/√3."""
    found = terms(command=commands(turn=0.3))
    assert found["commanded"] == 0
    assert found["path"] == 0
    assert found["heading"] == pytest.approx(-2 * LENGTH * 3.0 / np.sqrt(3), rel=0.01)
    assert terms(command=commands(turn=0.3), orientation=turned(0.3 * TIME))["heading"] == (
        pytest.approx(0, abs=1e-9)
    )


def test_the_path_restarts_at_the_pose_of_the_robot_but_the_heading_does_not():
    """After 2 s, the robot turns by 0.6 rad at once, and walks straight from then on."""
    yaw = np.where(TIME < 1.99, 0.0, 0.6)
    steps = 0.2 / 50 * np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], axis=-1)
    torso = np.cumsum(steps, axis=0) - steps[0]
    changed = {"torso": torso, "orientation": turned(yaw), "command": commands(0.2)}
    found = terms(**changed)
    assert found["path"] == pytest.approx(0, abs=1e-3)
    assert found["heading"] == pytest.approx(-2 * LENGTH * 0.6 * np.sqrt(0.8), rel=0.01)
    whole = terms(FollowFitness(window=10), **changed)
    # The robot leaves the path by 2 sin(0.3) times its distance since the turn, 0 to 1.6 m.
    assert whole["path"] == pytest.approx(-2 * np.sin(0.3) * 1.6 * 0.8, rel=0.01)


def test_changing_commands_are_followed():
    speed, turn = np.where(TIME < 4, 0.2, 0.0), np.where((TIME >= 4) & (TIME < 6), 0.7, 0.0)
    yaw = 0.7 * np.clip(TIME - 4, 0, 2)
    torso = np.stack([0.2 * np.minimum(TIME, 4), 0 * TIME, 0 * TIME], axis=-1)
    found = terms(command=commands(speed, turn), torso=torso, orientation=turned(yaw))
    assert found.pop("commanded") == pytest.approx(0.8)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    ("term", "changed", "expected"),
    [
        ("height", {"command": commands(height=0.03)}, -0.03),
        ("height", {"height": 0.2 - 0.05 * TIME / 10}, -0.025),
        ("fall", {"lasted": np.array(5.0)}, -15 * LENGTH),
        ("energy", {"energy": 6 * TIME}, -0.1 * 60 / WEIGHT),
        ("slip", {"slip": np.full(FRAMES, 0.01)}, -0.5 * 5.01),
    ],
)
def test_each_other_penalty_follows_its_definition(term, changed, expected):
    found = terms(**changed)
    assert found.pop(term) == pytest.approx(expected)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-9)


def test_a_body_without_commands_is_refused():
    with pytest.raises(ExperimentError, match="'command', which the body 'walker'"):
        load_experiment("walker", {"fitness.plugin": "follow"})
