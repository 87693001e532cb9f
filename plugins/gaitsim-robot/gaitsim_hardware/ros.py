"""Gaits for ROS 2: trajectories that end in the standing pose, as goals of an action."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Exported, GaitsimError
from gaitsim.plugin.gait import Gait, check_folder, gait_of
from gaitsim.plugin.runs import Individual, write_bytes
from gaitsim_hardware.exporting import fall_notices
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


def export_goal(
    individual: Individual, path: Path, keyframe_ms: int | None, speed: float
) -> Exported:
    """Write the gait of an individual as the goal of a ROS 2 action; options of `trajectory_of`."""
    check_folder(path)
    gait = gait_of(individual)
    trajectory, units = trajectory_of(gait, keyframe_ms, speed), gait.units
    data = format_goal(trajectory).encode()
    write_bytes(path, data)
    points, joints = trajectory.positions.shape
    seconds, notices = trajectory.nanoseconds[-1] / 1e9, fall_notices(individual)
    if len(data) >= MAX_ARGUMENT:
        notices = (
            *notices,
            f"the file is too long for a command-line argument: it has {len(data):,} bytes, and "
            f"Linux allows fewer than {MAX_ARGUMENT:,}. Pass it with --stdin (ROS 2 Jazzy or "
            "newer), or use fewer points with --keyframe-ms",
        )
    return Exported(f"{points} points × {joints} joints in {seconds:g} s, {units}", notices)


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
        np.vstack([positions, gait.standing]),
        np.vstack([velocities, np.zeros_like(gait.standing)]),
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


def _format_numbers(values: Floats, decimals: int) -> str:
    return ", ".join(f"{value:.{decimals}f}" for value in (np.round(values, decimals) + 0.0))


def _ramp_duration(pose: Floats, standing: Floats) -> float:
    """Return the duration of a ramp between two poses, s."""
    return max(MIN_RAMP, float(np.abs(pose - standing).max()) / RAMP_SPEED)
