"""Calibration files: reading them with all their problems at once, and templates."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from gaitsim.plugin import ExperimentError, GaitsimError, nearest, toml
from gaitsim.plugin.gait import Gait, check_folder
from gaitsim.plugin.runs import Problems, editing, invalid_value, read_file, write_bytes
from gaitsim.plugin.toolkit import SERVOS
from gaitsim_hardware.calibration import BUSES, Calibration, Joint

SCHEMA = 1
NOUN = "calibration"
_MAX_NAMES = 4


def read_calibration(
    path: Path, format: str, joints: Sequence[str], *, partial: bool = False
) -> Calibration:
    """Read the calibration of a robot with the given joints.

    Args:
        path: path of the TOML file.
        format: export format, such as 'arduino', which determines the type of servo.
        joints: names of the joints, in the order of the gait.
        partial: whether joints may be missing.
    """
    template = "the file that --calibration-template writes"
    text = read_file(path, NOUN, template, "write one with --calibration-template")
    problems = Problems(str(path))
    try:
        data = toml.parse(text, str(path))
    except GaitsimError as error:
        raise ExperimentError([error], NOUN) from None
    for key in data:
        if key not in ("schema", "joints"):
            problems.add_unknown_key("", key, ("schema", "joints"))
    if data.get("schema", SCHEMA) != SCHEMA:
        what = invalid_value("schema", toml.literal(data["schema"]))
        problems.report("schema", what, str(SCHEMA))
    given = data.get("joints", {})
    if not isinstance(given, dict):
        problems.report("joints", "'joints' is not a section", '[joints."name"] for each joint')
        given = {}
    found = _joints(given, joints, problems, partial=partial)
    if not problems.found:
        _check_format(found, format, problems)
    if problems.found:
        raise ExperimentError(problems.found[:20], NOUN)
    listed = {name: found[name] for name in joints if name in found}
    return Calibration(listed, str(path), f"in {path}")


def write_joint(path: Path, name: str, joint: Joint) -> None:
    """Write the servo of a joint on a bus to a calibration file; the rest of the file stays."""
    with editing(path) as document:
        document.setdefault("schema", SCHEMA)
        left_out = {"board", "channel", "pulse"}
        section = joint.model_dump(exclude=left_out, exclude_none=True)
        document.setdefault("joints", {})[name] = section


def _joints(
    given: Mapping[str, Any], joints: Sequence[str], problems: Problems, *, partial: bool
) -> dict[str, Joint]:
    extra = [name for name in given if name not in joints]
    missing = [name for name in joints if name not in given and not partial]
    if extra:
        problems.report(
            "joints",
            f"the gait does not have the joint{'s' * (len(extra) > 1)} {_list_names(extra)}",
            f"the joints of the gait: {', '.join(joints)}",
            nearest(extra[0], missing),
        )
    if missing:
        problems.report(
            "joints",
            f"{_list_names(missing)} {'is' if len(missing) == 1 else 'are'} missing",
            "all joints of the gait",
            "calibrate them with 'gaitsim robots calibrate', or create a new file with "
            "--calibration-template and copy the joints from it",
        )
    found = {}
    for name, section in given.items():
        if name in extra:
            continue
        key = f"joints.{json.dumps(name, ensure_ascii=False)}"
        if not isinstance(section, dict):
            problems.report(key, f"{key} is not a section", f"[{key}], followed by its keys")
            continue
        try:
            found[name] = Joint.model_validate(section)
        except ValidationError as error:
            problems.add_option_errors(key, Joint, section, error)
    return found


def _check_format(found: Mapping[str, Joint], format: str, problems: Problems) -> None:
    """Report missing or duplicate channels and ids, and servos that the format cannot drive."""
    bus = BUSES.get(format)
    if bus is None:
        return
    kind = "channel" if bus == "pwm" else "id"
    taken: dict[tuple[int, int | None], str] = {}
    for name, joint in found.items():
        section = f"joints.{json.dumps(name, ensure_ascii=False)}"
        key = f"{section}.{kind}"
        address = (joint.board, joint.channel) if bus == "pwm" else (0, joint.id)
        if address[1] is None:
            problems.report(key, f"{key} is required for {format}")
        elif address in taken:
            board = f" of board {address[0]}" if bus == "pwm" else ""
            problems.report(
                key,
                f"{taken[address]} and {name} have the same {kind} {address[1]}{board}",
                f"a different {kind} for each joint",
            )
        taken.setdefault(address, name)
        servo = joint.model
        if (servo is None and bus != "pwm") or (servo and servo.bus != bus):
            problems.report(
                f"{section}.servo",
                f"the servo {servo.name} cannot be used with {format}"
                if servo
                else f"{format} needs the model of the servo of {name}",
                ", ".join(one.name for one in SERVOS.values() if one.bus == bus),
            )


def _list_names(names: Iterable[str]) -> str:
    found = [toml.literal(name) for name in names]
    more = len(found) - _MAX_NAMES
    return ", ".join(found[:_MAX_NAMES]) + (f" and {more} more" if more > 0 else "")


_ADDRESS_KEYS = {
    "arduino": "board, channel  PCA9685 board (0 at 0x40, 1 at 0x41, …) and its output, 0 to 15",
    "dynamixel": "id              id of the servo on its bus, 0 to 252",
    "feetech": "id              id of the servo on its bus, 0 to 252",
}
_HEADER = """\
# Calibration of a robot for `gaitsim export --format {format} --calibration FILE`.
#
# Angles are in degrees from the servo's centre: servo = direction × joint + offset.
# With the values below, the servos are centred when the robot stands: centre them, then attach the
# horns. Suspend the robot, check the joints one by one, and correct the values that differ.
#
#   {address}
#   direction       1, or -1 if the servo turns opposite to the joint
#   offset          angle of the servo when the joint is at zero, °
#   min, max        range in which the servo can turn without touching anything, °
{pulse}#   servo           model of the servo: {servos}
#   speed           largest speed, °/s; by default the model's speed without load
#
# See "From simulation to your robot" in the docs for step-by-step instructions.

schema = {schema}
"""
_PULSE = (
    "#   pulse           µs at -90° and at 90° of the servo; extrapolate if it cannot reach them\n"
)


def format_template(gait: Gait, calibration: Calibration, format: str) -> str:
    """Return a commented calibration file that states the range of each joint in the gait."""
    on_board = format == "arduino"
    parts = [
        _HEADER.format(
            format=format,
            address=_ADDRESS_KEYS[format],
            pulse=_PULSE if on_board else "",
            servos=", ".join(name for name, servo in SERVOS.items() if servo.bus == BUSES[format])
            + (", or empty for others" if on_board else ""),
            schema=SCHEMA,
        )
    ]
    degrees = np.degrees(gait.angles)
    speeds = np.abs(np.diff(degrees, axis=0)).max(axis=0) * gait.frame_rate
    for index, (name, joint) in enumerate(calibration.joints.items()):
        low, high = degrees[:, index].min(), degrees[:, index].max()
        lines = [
            "",
            f"[joints.{json.dumps(name, ensure_ascii=False)}]"
            f"  # in this gait {low:.1f}° to {high:.1f}°, up to {speeds[index]:.0f}°/s",
        ]
        if on_board:
            lines += [f"board = {joint.board}", f"channel = {joint.channel}"]
        else:
            lines += [f"id = {joint.id}"]
        lines += [f"direction = {joint.direction}", f"offset = {joint.offset}"]
        lines += [f"min = {joint.min}", f"max = {joint.max}"]
        if on_board:
            lines += [f"pulse = [{joint.pulse[0]}, {joint.pulse[1]}]"]
        lines += [f'servo = "{joint.servo}"']
        parts.append("\n".join(lines) + "\n")
    return "".join(parts)


def write_template(gait: Gait, calibration: Calibration, format: str, path: Path) -> None:
    """Write a calibration template for users to fill in."""
    check_folder(path)
    if os.path.lexists(path):
        raise GaitsimError(
            f"the file {path} already exists",
            where="--calibration-template",
            allowed="a new file, so that no calibration is overwritten",
        )
    write_bytes(path, format_template(gait, calibration, format).encode())
