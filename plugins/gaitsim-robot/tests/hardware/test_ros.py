"""ROS 2 trajectories and bags, read back with independent readers."""

import sqlite3
import struct

import numpy as np
import pytest
import yaml

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_hardware.ros import trajectory_of, write_goal

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


def test_the_goal_reads_back_as_the_gait(gait, tmp_path):
    path = tmp_path / "goal.yaml"
    assert write_goal(trajectory_of(gait), path) == path.stat().st_size
    goal = yaml.safe_load(path.read_text())
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


class Cdr:
    """A reader of OMG CDR, little-endian, with alignments relative to the end of the header."""

    def __init__(self, data):
        assert data[:4] == b"\0\1\0\0"
        self.data, self.at = data[4:], 0

    def take(self, form):
        size = struct.calcsize(form)
        self.at += -self.at % size
        (value,) = struct.unpack_from(f"<{form}", self.data, self.at)
        self.at += size
        return value

    def text(self):
        size = self.take("I")
        value = self.data[self.at : self.at + size - 1].decode()
        self.at += size
        return value

    def many(self, one):
        return [one() for _ in range(self.take("I"))]

    def doubles(self):
        return self.many(lambda: self.take("d"))

    def header(self):
        return self.take("i"), self.take("I"), self.text()

    def point(self):
        values = [self.doubles() for _ in range(4)]
        return *values, self.take("i") * 10**9 + self.take("I")


def test_the_bag_reads_back_as_the_gait(gait, tmp_path):
    pytest.importorskip("rosbags")
    from gaitsim_hardware.ros import write_bag

    path, trajectory = tmp_path / "walk", trajectory_of(gait)
    write_bag(trajectory, path)
    write_bag(trajectory, path)  # which replaces it
    assert sorted(part.name for part in tmp_path.iterdir()) == ["walk"]
    assert sorted(part.name for part in path.iterdir()) == ["metadata.yaml", "walk.db3"]
    about = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["relative_file_paths"] == ["walk.db3"]
    assert about["message_count"] == FRAMES + 2
    with sqlite3.connect(path / "walk.db3") as database:
        topics = dict(database.execute("select id, name || ' ' || type from topics"))
        rows = database.execute("select topic_id, timestamp, data from messages order by id")
        messages = [(topics[topic], time, Cdr(data)) for topic, time, data in rows]
    database.close()
    (name, time, first), *states = messages
    assert name.split() == [
        "/joint_trajectory_controller/joint_trajectory",
        "trajectory_msgs/msg/JointTrajectory",
    ]
    assert (time, first.header(), tuple(first.many(first.text))) == (0, (0, 0, ""), NAMES)
    points = first.many(first.point)
    assert first.at == len(first.data)
    assert np.abs(np.array([point[0] for point in points])[:-1] - gait.angles).max() < 1e-9
    assert np.array([point[1] for point in points]) == pytest.approx(trajectory.velocities)
    assert [point[4] for point in points] == trajectory.nanoseconds.tolist()
    for (name, time, state), position in zip(states, trajectory.positions, strict=True):
        assert name == "/joint_states sensor_msgs/msg/JointState"
        seconds, rest, _ = state.header()
        assert seconds * 10**9 + rest == time
        assert tuple(state.many(state.text)) == NAMES
        assert np.abs(np.array(state.doubles()) - position).max() < 1e-9


def test_a_bag_reads_back_with_the_ros_types(gait, tmp_path):
    reading = pytest.importorskip("rosbags.highlevel")
    from rosbags.typesys import Stores, get_typestore

    from gaitsim_hardware.ros import write_bag

    write_bag(trajectory_of(gait), tmp_path / "walk")
    store = get_typestore(Stores.ROS2_HUMBLE)
    with reading.AnyReader([tmp_path / "walk"], default_typestore=store) as reader:
        messages = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic.endswith("joint_trajectory")
        ]
    (trajectory,) = messages
    assert trajectory.joint_names == [*NAMES]
    positions = np.array([point.positions for point in trajectory.points])
    assert np.abs(positions[:-1] - gait.angles).max() < 1e-9


def test_a_folder_that_is_not_a_bag_is_not_replaced(gait, tmp_path):
    pytest.importorskip("rosbags")
    from gaitsim_hardware.ros import write_bag

    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(GaitsimError, match="exists and is not a rosbag2"):
        write_bag(trajectory_of(gait), tmp_path / "mine")
    assert (tmp_path / "mine" / "notes.txt").read_text() == "mine"
