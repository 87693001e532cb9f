"""Gaits for ROS 2: trajectories that end in the standing pose, and rosbag2 recordings."""

import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, RunError, not_installed
from gaitsim.plugin.gait import Gait, check_folder, check_parent
from gaitsim.plugin.runs import draft_folder, sync_folder, write_bytes, writing
from gaitsim_hardware.keyframes import check_playback, interpolate

Floats = NDArray[np.float64]

MIN_RAMP = 2.0  # s, shortest time from the robot's pose to the gait, and from the gait to standing
RAMP_SPEED = 0.5  # rad/s, mean speed of the fastest joint in a longer ramp
MAX_ARGUMENT = 131_072  # bytes of a command-line argument on Linux, including the final zero


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Points of a `trajectory_msgs/JointTrajectory`.

    Attributes:
        joint_names: name of each joint.
        nanoseconds: time from the start to each point, (points,) int64. The first is above 0, so
            that the controller has time to move there from the robot's current pose.
        positions: joint angles of the gait, then of the standing pose, (points, joints) rad.
        velocities: velocities of the joints, (points, joints) rad/s. They are 0 in the first and
            last points of the gait and in the standing pose; otherwise the splines of the ramps
            would overshoot.
    """

    joint_names: tuple[str, ...]
    nanoseconds: NDArray[np.int64]
    positions: Floats
    velocities: Floats


def trajectory_of(gait: Gait, keyframe_ms: int | None = None, speed: float = 1.0) -> Trajectory:
    """Return the trajectory of a gait.

    The velocities are central differences of the positions, with which the cubic splines of a
    `joint_trajectory_controller` pass smoothly through the points.

    Args:
        gait: joint angles of the gait.
        keyframe_ms: time between points, ms; None for one point per frame.
        speed: speed of playback; 1 is the speed of the simulation.
    """
    check_playback(speed)
    seconds = np.arange(len(gait.angles)) / gait.frame_rate / speed
    positions = gait.angles
    if keyframe_ms is not None:
        known, seconds = seconds, np.arange(0, seconds[-1] + 5e-10, keyframe_ms / 1000)
        positions = interpolate(seconds, known, gait.angles)
    if len(seconds) < 2:
        raise GaitsimError(
            "the gait is shorter than the time between points",
            where="" if keyframe_ms is None else f"--keyframe-ms {keyframe_ms}",
        )
    velocities = np.gradient(positions, float(seconds[1]), axis=0)
    velocities[[0, -1]] = 0.0
    seconds += _ramp_duration(positions[0], gait.standing)
    end = seconds[-1] + _ramp_duration(positions[-1], gait.standing)
    return Trajectory(
        gait.joint_names,
        np.rint(np.append(seconds, end) * 1e9).astype(np.int64),
        np.ascontiguousarray(np.vstack([positions, gait.standing])),
        np.ascontiguousarray(np.vstack([velocities, np.zeros_like(gait.standing)])),
    )


def format_goal(trajectory: Trajectory) -> str:
    """Return the goal of a `control_msgs/action/FollowJointTrajectory` as YAML."""
    lines = ["trajectory:", "  joint_names:"]
    # A JSON string is valid YAML, whatever characters a name contains.
    lines += [f"  - {json.dumps(name)}" for name in trajectory.joint_names]
    lines.append("  points:")
    for time, position, velocity in zip(
        trajectory.nanoseconds.tolist(), trajectory.positions, trajectory.velocities, strict=True
    ):
        seconds, nanoseconds = divmod(time, 10**9)
        lines += [
            f"  - positions: [{_format_numbers(position, 10)}]",
            f"    velocities: [{_format_numbers(velocity, 6)}]",
            f"    time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}",
        ]
    return "\n".join(lines) + "\n"


def write_goal(trajectory: Trajectory, path: Path) -> int:
    """Write the goal of a trajectory as YAML, atomically, and return its size in bytes."""
    check_folder(path)
    data = format_goal(trajectory).encode()
    write_bytes(path, data)
    return len(data)


def _format_numbers(values: Floats, decimals: int) -> str:
    return ", ".join(f"{value:.{decimals}f}" for value in (np.round(values, decimals) + 0.0))


def _ramp_duration(pose: Floats, standing: Floats) -> float:
    """Return the duration of a ramp between two poses, s."""
    return max(MIN_RAMP, float(np.abs(pose - standing).max()) / RAMP_SPEED)


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
        raise not_installed(
            "a rosbag2", error.name, "ros", source="gaitsim-robot", where="--format rosbag2"
        ) from None


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
