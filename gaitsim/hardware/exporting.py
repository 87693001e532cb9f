"""Export gaits to files that robots can play."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from gaitsim.choices import GaitFormat, RosFormat
from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait, gait_of, write_gait
from gaitsim.gait.report import frames_before_fall
from gaitsim.hardware.arduino import FLASH, MAX_NAME, create_sketch, sketch_name, write_sketch
from gaitsim.hardware.calibration import (
    BUSES,
    HALF_RANGE,
    Calibration,
    default_calibration,
    uniform_calibration,
)
from gaitsim.hardware.calibration_file import read_calibration
from gaitsim.hardware.keyframes import Keyframes, keyframes_of
from gaitsim.hardware.loop import Loop, find_loop
from gaitsim.hardware.options import ENDINGS, Options, check_options
from gaitsim.hardware.rosbag import check_installed, write_bag
from gaitsim.hardware.tables import write_degrees, write_ticks
from gaitsim.hardware.template import write_template
from gaitsim.hardware.trajectory import MAX_ARGUMENT, trajectory_of, write_goal
from gaitsim.individual import Individual


@dataclass(frozen=True)
class Exported:
    """The result of an export.

    Attributes:
        summary: description of the exported content, one line.
        notices: notices for the user.
    """

    summary: str
    notices: tuple[str, ...] = ()


def check_bag(individual: Individual) -> None:
    """Check that an individual's gait can be exported as a bag."""
    gait_of(individual)
    check_installed()


def file_name(individual: Individual, format: str) -> str:
    """Return the default file name for an individual's gait."""
    name = f"gait-{individual.stem}"
    if format == "arduino":
        name = re.sub(r"[^0-9A-Za-z]+", "_", name)[:MAX_NAME]
    return f"{name}{ENDINGS[format]}"


def export_individual(
    individual: Individual, format: str, path: Path, options: Options | None = None
) -> Exported:
    """Export the gait of an individual.

    Args:
        individual: individual of a run or from a file.
        format: 'mat', 'csv', 'npz', 'servo', 'arduino', 'dynamixel', 'feetech', 'ros2' or
            'rosbag2'.
        path: path of the file, or of the folder of a sketch or bag.
        options: options of the formats for robots; None for the defaults.
    """
    options = options or Options()
    check_options(format, options)
    gait = gait_of(individual)
    frames, joints = gait.angles.shape
    if format in get_args(GaitFormat):
        write_gait(gait, path, format)
        return Exported(f"{frames} frames × {joints} joints at {gait.frame_rate:g} Hz, radians")
    fall = _fall_notices(individual, frames)
    if format in get_args(RosFormat):
        found = _ros(gait, format, path, options)
        return replace(found, notices=(*fall, *found.notices))
    if format == "servo" and options.calibration is None:
        centre = options.centre or 0.0
        low = centre - HALF_RANGE if options.low is None else options.low
        high = centre + HALF_RANGE if options.high is None else options.high
        assumed: tuple[str, ...] = ()
        calibration = uniform_calibration(gait.joint_names, centre, low, high)
    else:
        calibration, assumed = _calibration(
            gait, format, options.calibration, _simulated_servo(individual)
        )
    if format == "arduino":
        found = _arduino(gait, calibration, path, options, individual.title)
    else:
        found = _table(gait, calibration, format, path, options)
    return replace(found, notices=(*fall, *assumed, *found.notices))


def _fall_notices(individual: Individual, frames: int) -> tuple[str, ...]:
    """Return a notice if the body falls in the simulation; () otherwise."""
    upright = frames_before_fall(individual)
    if upright >= frames:
        return ()
    seconds = upright / individual.motion.frame_rate
    return (f"in the simulation, the body falls after {seconds:.1f} s of this gait",)


def export_template(individual: Individual, format: str, path: Path) -> None:
    """Write a calibration template for the gait of an individual.

    Args:
        individual: individual with the robot's body.
        format: 'arduino', 'dynamixel' or 'feetech'.
        path: path of the new file.
    """
    if format not in BUSES:
        raise GaitsimError(
            f"the format {format!r} has no calibration template",
            where="--format",
            allowed=", ".join(BUSES),
        )
    gait = gait_of(individual)
    calibration = default_calibration(
        format, gait.joint_names, gait.standing, _simulated_servo(individual)
    )
    write_template(gait, calibration, format, path)


def _simulated_servo(individual: Individual) -> str:
    """Return the name of the robot's simulated servo; '' for other bodies."""
    return str(getattr(individual.experiment.organism, "servo", ""))


def _calibration(
    gait: Gait, format: str, path: Path | None, servo: str
) -> tuple[Calibration, tuple[str, ...]]:
    if path is not None:
        return read_calibration(path, format, gait.joint_names), ()
    found = default_calibration(format, gait.joint_names, gait.standing, servo)
    name = next(iter(found.joints.values())).servo
    addresses = "channels from 0" if format == "arduino" else "ids from 1"
    speed = "" if name else "; their speed is unknown and was not checked"
    return found, (
        f"no calibration: assumed {addresses} in the order of the joints, and {name or 'hobby'} "
        f"servos that are centred in the standing pose{speed}. Create a calibration with "
        f"--calibration-template FILE before you play this file on a robot",
    )


def _ros(gait: Gait, format: str, path: Path, options: Options) -> Exported:
    trajectory = trajectory_of(gait, options.keyframe_ms, options.playback)
    points, joints = trajectory.positions.shape
    seconds = trajectory.nanoseconds[-1] / 1e9
    summary = f"{points} points × {joints} joints in {seconds:g} s, radians"
    if format == "rosbag2":
        write_bag(trajectory, path)
        return Exported(summary)
    size = write_goal(trajectory, path)
    if size < MAX_ARGUMENT:
        return Exported(summary)
    return Exported(
        summary,
        (
            f"the file is too long for a command-line argument: it has {size:,} bytes, and Linux "
            f"allows fewer than {MAX_ARGUMENT:,}. Pass it with --stdin (ROS 2 Jazzy or newer), or "
            "use fewer points with --keyframe-ms",
        ),
    )


def _arduino(
    gait: Gait, calibration: Calibration, path: Path, options: Options, title: str
) -> Exported:
    name = sketch_name(path)
    loop = find_loop(gait.angles, gait.frame_rate)
    keyframes = _keyframes(gait, calibration, options, loop)
    sketch = create_sketch(keyframes, calibration, name, title)
    write_sketch(sketch, path)
    count, joints = keyframes.degrees.shape
    if loop is None:
        played = "played once, as no part of the gait repeats"
    else:
        period = loop.period / options.playback
        played = f"a loop of {period:.3f} s that repeats to within {np.degrees(loop.error):.2f}°"
    return Exported(
        f"{count} keyframes × {joints} joints every {keyframes.interval * 1000:.3g} ms, {played}; "
        f"{sketch.flash:,} bytes of flash (at most {FLASH:,}), for {sketch.boards} "
        f"PCA9685 board{'s' * (sketch.boards > 1)}; at most {keyframes.deviation:.2f}° from the "
        "gait",
        _clipping_notices(keyframes),
    )


def _table(
    gait: Gait, calibration: Calibration, format: str, path: Path, options: Options
) -> Exported:
    keyframes = _keyframes(gait, calibration, options, None)
    if format == "servo":
        write_degrees(keyframes, path)
        unit = "degrees"
    else:
        write_ticks(keyframes, calibration, path)
        unit = "goal positions by id"
    count, joints = keyframes.degrees.shape
    return Exported(
        f"{count} keyframes × {joints} joints in {keyframes.milliseconds[-1] / 1000:g} s, {unit}; "
        f"at most {keyframes.deviation:.2f}° from the gait",
        _clipping_notices(keyframes),
    )


def _keyframes(
    gait: Gait, calibration: Calibration, options: Options, loop: Loop | None
) -> Keyframes:
    return keyframes_of(
        gait, calibration, options.keyframe_ms, speed=options.playback, clip=options.clip, loop=loop
    )


def _clipping_notices(keyframes: Keyframes) -> tuple[str, ...]:
    if not keyframes.clipped:
        return ()
    return (
        f"{keyframes.clipped:,} of {keyframes.degrees.size:,} angles were beyond the range of "
        "their servos and were clipped: the result differs from the evolved gait",
    )
