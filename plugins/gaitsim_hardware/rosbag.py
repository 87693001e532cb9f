"""Gaits as rosbag2 recordings."""

import os
import shutil
from pathlib import Path
from typing import Any

from gaitsim.errors import RunError, not_installed
from gaitsim.gait.gait_files import check_parent
from gaitsim.runs.files.atomic import draft_folder, sync_folder, writing
from gaitsim_hardware.trajectory import Trajectory

COMMAND_TOPIC = "/joint_trajectory_controller/joint_trajectory"
STATE_TOPIC = "/joint_states"
VERSION = 8  # the newest version that ROS 2 Humble reads
_SUFFIXES = (".db3", ".yaml")


def write_bag(trajectory: Trajectory, path: Path) -> None:
    """Write a rosbag2 folder in SQLite format, which ROS 2 Humble and all newer releases can play.

    The bag contains the whole trajectory as one `trajectory_msgs/JointTrajectory`, on the topic
    that a `joint_trajectory_controller` reads. For visualisation, it also contains the positions
    as `sensor_msgs/JointState`, one message per point. An existing bag at `path` is replaced.
    """
    check_installed()
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    _check_target(path)
    store = get_typestore(Stores.ROS2_HUMBLE)
    with writing(path), draft_folder(path.parent) as draft:
        bag = draft / path.name  # a bag names its files after its folder
        with Writer(bag, version=VERSION, storage_plugin=StoragePlugin.SQLITE3) as writer:
            _write_messages(writer, store, trajectory)
        shutil.rmtree(path, ignore_errors=True)
        bag.replace(path)
        sync_folder(path.parent)


def check_installed() -> None:
    """Raise an error if the package rosbags is not installed."""
    try:
        import rosbags.rosbag2  # noqa: F401
    except ImportError as error:
        raise not_installed("a rosbag2", error.name, "ros", where="--format rosbag2") from None


def _write_messages(writer: Any, store: Any, trajectory: Trajectory) -> None:
    types = store.types
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    duration = types["builtin_interfaces/msg/Duration"]
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    command, state = "trajectory_msgs/msg/JointTrajectory", "sensor_msgs/msg/JointState"
    empty = trajectory.positions[0, :0]
    names = list(trajectory.joint_names)
    rows = [
        (divmod(time, 10**9), time, position, velocity)
        for time, position, velocity in zip(
            trajectory.nanoseconds.tolist(),
            trajectory.positions,
            trajectory.velocities,
            strict=True,
        )
    ]
    points = [
        point(position, velocity, empty, empty, duration(*parts))
        for parts, _, position, velocity in rows
    ]
    # The time 0 in the header makes the controller start when the message arrives.
    message = types[command](header(stamp(0, 0), ""), names, points)
    commands = writer.add_connection(COMMAND_TOPIC, command, typestore=store)
    writer.write(commands, 0, store.serialize_cdr(message, command))
    states = writer.add_connection(STATE_TOPIC, state, typestore=store)
    for parts, time, position, velocity in rows:
        message = types[state](header(stamp(*parts), ""), names, position, velocity, empty)
        writer.write(states, time, store.serialize_cdr(message, state))


def _check_target(path: Path) -> None:
    """Raise an error if a path exists and is not a bag."""
    check_parent(path)
    if not os.path.lexists(path):
        return
    bag = path.is_dir() and not path.is_symlink() and (path / "metadata.yaml").is_file()
    if not bag or any(file.suffix not in _SUFFIXES for file in path.iterdir()):
        raise RunError(
            f"cannot write {path}: it exists and is not a rosbag2",
            remedy="choose a different folder with --out",
        )
