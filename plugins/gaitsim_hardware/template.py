"""Write a calibration template for users to fill in."""

import json
import os
from pathlib import Path

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait, check_folder
from gaitsim.legged import SERVOS
from gaitsim.runs.files.atomic import write_bytes
from gaitsim_hardware.calibration import BUSES, Calibration
from gaitsim_hardware.calibration_file import SCHEMA

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
