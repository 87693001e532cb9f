"""ROS 2 trajectories, read back with an independent reader."""

import numpy as np
import pytest
import yaml

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_hardware.ros import format_goal, trajectory_of

NAMES = ("hip: [1]", 'knee "left"', "# foot")
REST = np.array([0.1, 0.0, -0.4])
FRAMES = 61


@pytest.fixture
def gait():
    times = np.arange(FRAMES)[:, None] / 30
    angles = np.sin(2 * np.pi * times + np.arange(3)) / 3
    # In Fortran order, as for a body that computes its channels joint by joint.
    return Gait(np.asfortranarray(angles), NAMES, 30.0, 1, 0.0, REST)


def nanoseconds(duration):
    return duration["sec"] * 10**9 + duration["nanosec"]


def test_the_goal_reads_back_as_the_gait(gait):
    goal = yaml.safe_load(format_goal(trajectory_of(gait)))
    # A goal of control_msgs/action/FollowJointTrajectory; omitted fields have their defaults.
    assert goal.keys() == {"trajectory"}
    assert goal["trajectory"].keys() == {"joint_names", "points"}
    assert tuple(goal["trajectory"]["joint_names"]) == NAMES
    points = goal["trajectory"]["points"]
    assert all(point.keys() == {"positions", "velocities", "time_from_start"} for point in points)
    positions = np.array([point["positions"] for point in points])
    assert np.abs(positions[:-1] - gait.angles).max() < 1e-9
    assert positions[-1] == pytest.approx(REST, abs=1e-9)
    times = np.array([nanoseconds(point["time_from_start"]) for point in points]) / 1e9
    assert times[0] == 2
    assert times[:-1] - times[0] == pytest.approx(np.arange(FRAMES) / 30, abs=1e-9)
    assert times[-1] == pytest.approx(times[-2] + 2)


def test_velocities_are_the_slopes_and_the_ends_are_at_rest(gait):
    found = trajectory_of(gait)
    exact = 2 * np.pi / 3 * np.cos(2 * np.pi * np.arange(FRAMES)[:, None] / 30 + np.arange(3))
    inner = slice(1, FRAMES - 1)
    assert found.velocities[inner] == pytest.approx(exact[inner], abs=0.02)  # of 2.1 rad/s
    # Controllers refuse a goal that ends in motion.
    assert not found.velocities[[0, -2, -1]].any()


def test_playback_speed_and_keyframe_time_set_the_points(gait):
    found = trajectory_of(gait, 200, 0.5)
    seconds = found.nanoseconds / 1e9
    assert np.diff(seconds[:-1]) == pytest.approx(0.2)
    assert found.positions[:-1] == pytest.approx(gait.angles[::3], abs=1e-12)
    far = Gait(gait.angles, NAMES, 30.0, 1, 0.0, REST + 2)
    assert trajectory_of(far).nanoseconds[0] > 4e9  # at most 0.5 rad/s
    with pytest.raises(GaitsimError, match="shorter than"):
        trajectory_of(gait, 60_000)
