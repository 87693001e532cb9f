"""Export gaits to files that robots can play."""

import math
from pathlib import Path

import numpy as np

from gaitsim.plugin import Exported, GaitsimError
from gaitsim.plugin.gait import Gait, frames_before_fall, gait_of
from gaitsim.plugin.runs import Individual
from gaitsim_hardware.arduino import (
    FLASH,
    check_standing,
    create_controller_sketch,
    create_receiver_sketch,
    create_sketch,
    sketch_name,
    write_sketch,
)
from gaitsim_hardware.c_code import controller_of, needs_of
from gaitsim_hardware.calibration import Calibration, default_calibration
from gaitsim_hardware.calibration_file import read_calibration, write_template
from gaitsim_hardware.keyframes import (
    Keyframes,
    find_loop,
    keyframes_of,
    write_table,
)

MOST_STREAMED = 64  # joints whose pulses and status fit into 20 ms at 115200 baud


def export_keyframes(
    individual: Individual,
    format: str,
    path: Path,
    servos: Calibration | Path | None,
    keyframe_ms: int | None,
    speed: float,
    *,
    clip: bool,
) -> Exported:
    """Write the gait of an individual for servos.

    Args:
        individual: individual with joint angles.
        format: 'servo', 'arduino', 'dynamixel' or 'feetech'.
        path: path of the file, or of the folder of a sketch.
        servos: calibration of the servos, or its TOML file; None for servos centred in the standing
            pose.
        keyframe_ms: time between keyframes, ms; None for one keyframe per frame.
        speed: playback speed.
        clip: whether to clip angles beyond the limits instead of raising an error.
    """
    name = sketch_name(path) if format == "arduino" else ""
    gait, calibration, assumed = gait_of(individual), servos, ""
    if not isinstance(calibration, Calibration):
        calibration, assumed = _calibration(individual, gait, format, calibration)
    loop = find_loop(gait.angles, gait.frame_rate) if format == "arduino" else None
    keyframes = keyframes_of(gait, calibration, keyframe_ms, speed=speed, clip=clip, loop=loop)
    count, joints = keyframes.degrees.shape
    if format == "arduino":
        sketch = create_sketch(keyframes, calibration, name, individual.title)
        write_sketch(sketch, path)
        played = "played once, as no part of the gait repeats"
        if loop is not None:
            repeats = f"that repeats to within {np.degrees(loop.error):.2f}°"
            played = f"a loop of {loop.period / speed:.3f} s {repeats}"
        about = (
            f"every {keyframes.interval * 1000:.3g} ms, {played}; {sketch.flash:,} bytes of flash "
            f"(at most {FLASH:,}), for {sketch.boards} PCA9685 board{'s' * (sketch.boards > 1)}"
        )
    else:
        unit = "degrees" if format == "servo" else "goal positions by id"
        write_table(keyframes, calibration, format, path)
        about = f"in {keyframes.milliseconds[-1] / 1000:g} s, {unit}"
    summary = (
        f"{count} keyframes × {joints} joints {about}; at most {keyframes.deviation:.2f}° from the "
        "gait"
    )
    notices = (assumed, _unchecked(calibration), _clipped(keyframes))
    return Exported(summary, (*fall_notices(individual), *filter(None, notices)))


def export_controller(
    individual: Individual, path: Path, file: Path | None, *, clip: bool
) -> Exported:
    """Write the reflexes of an individual as an Arduino sketch that follows commands.

    Args:
        individual: individual of a body whose gaits follow commands.
        path: path of the folder.
        file: TOML file of the calibration; None for servos centred in the standing pose.
        clip: whether to accept a simulated walk with angles beyond the limits, which the sketch
            clips.
    """
    name, gait = sketch_name(path), gait_of(individual)
    calibration, assumed = _calibration(individual, gait, "arduino", file)
    simulated = keyframes_of(gait, calibration, clip=clip)
    check_standing(simulated.standing, calibration)
    controller = controller_of(individual)
    sketch = create_controller_sketch(controller, calibration, name, individual.title)
    write_sketch(sketch, path)
    summary = (
        f"a sketch that follows commands, for {sketch.boards} PCA9685 "
        f"board{'s' * (sketch.boards > 1)} and an MPU6050; {len(gait.joint_names)} joints, "
        f"reflexes: {', '.join(controller.reflexes) or 'none'}"
    )
    contacts = (
        "the reflexes need contacts: connect a switch in each foot, and set CONTACT_PINS in the "
        "sketch"
    )
    felt = needs_of(controller) & {"contacts", "load"}
    unchecked = _unchecked(calibration)
    notices = (assumed, unchecked, _clipped(simulated), contacts if felt else "")
    return Exported(summary, (*fall_notices(individual), *filter(None, notices)))


def export_receiver(individual: Individual, path: Path, file: Path | None) -> Exported:
    """Write an Arduino sketch that plays pulses that a program sends.

    Args:
        individual: individual with the robot's body.
        path: path of the folder.
        file: TOML file of the calibration; None for servos centred in the standing pose.
    """
    name, gait = sketch_name(path), gait_of(individual)
    calibration, assumed = _calibration(individual, gait, "arduino", file)
    if len(gait.joint_names) > MOST_STREAMED:
        raise GaitsimError(
            f"the robot has {len(gait.joint_names)} joints",
            where="--stream",
            allowed=f"at most {MOST_STREAMED}, whose pulses take 20 ms at 115200 baud",
        )
    body = individual.experiment.name
    write_sketch(create_receiver_sketch(calibration, name, body), path)
    summary = f"a sketch that plays pulses sent over USB, {len(gait.joint_names)} joints"
    return Exported(summary, tuple(filter(None, (assumed,))))


def feels(individual: Individual) -> bool:
    """Return whether reflexes or a driver changed the gait of an individual."""
    felt = getattr(individual.experiment.organism, "feels", False)
    return bool(felt) and individual.genome is not None


def _unchecked(calibration: Calibration) -> str:
    """Return a notice about servos in a calibration file whose speed is unknown; '' for none."""
    names = [name for name, joint in calibration.joints.items() if joint.max_speed == math.inf]
    if not (calibration.source and names):
        return ""
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return (
        f"the speed of the servo of {names[0]}{more} is unknown and was not checked: set 'servo' "
        f"or 'speed' in {calibration.source}"
    )


def _clipped(keyframes: Keyframes) -> str:
    """Return a notice about angles that were clipped; '' for none."""
    if not keyframes.clipped:
        return ""
    return (
        f"{keyframes.clipped:,} of {keyframes.degrees.size:,} angles were beyond the range of "
        "their servos and were clipped: the result differs from the evolved gait"
    )


def fall_notices(individual: Individual) -> tuple[str, ...]:
    """Return a notice if the body falls in the simulation; () otherwise."""
    upright = frames_before_fall(individual)
    if upright >= len(gait_of(individual).angles):
        return ()
    seconds = upright / individual.motion.frame_rate
    return (f"in the simulation, the body falls after {seconds:.1f} s of this gait",)


def export_template(individual: Individual, format: str, path: Path) -> Exported:
    """Write a calibration template for the gait of an individual.

    Args:
        individual: individual with the robot's body.
        format: 'arduino', 'dynamixel' or 'feetech'.
        path: path of the new file.
    """
    gait = gait_of(individual)
    calibration = default_calibration(
        format, gait.joint_names, gait.standing, _simulated_servo(individual)
    )
    write_template(gait, calibration, format, path)
    return Exported("fill in this calibration, then give it to --calibration")


def _simulated_servo(individual: Individual) -> str:
    """Return the name of the robot's simulated servo; '' for other bodies."""
    return str(getattr(individual.experiment.organism, "servo", ""))


def _calibration(
    individual: Individual, gait: Gait, format: str, file: Path | None
) -> tuple[Calibration, str]:
    """Return the calibration in a file, or the default one and a notice about its assumptions."""
    if file is not None:
        return read_calibration(file, format, gait.joint_names), ""
    servo = _simulated_servo(individual)
    found = default_calibration(format, gait.joint_names, gait.standing, servo)
    name = next(iter(found.joints.values())).servo
    addresses = "channels from 0" if format == "arduino" else "ids from 1"
    speed = "" if name else "; their speed is unknown and was not checked"
    return found, (
        f"no calibration: assumed {addresses} in the order of the joints, and {name or 'hobby'} "
        f"servos that are centred in the standing pose{speed}. Create a calibration with "
        f"--calibration-template FILE before you play this file on a robot"
    )
