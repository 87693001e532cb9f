"""Gaits as Arduino sketches for hobby servos on PCA9685 boards."""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait.files.writer import check_parent
from gaitsim.hardware.calibration import Calibration
from gaitsim.hardware.keyframes import DECIMALS, Keyframes, beyond_range
from gaitsim.runs.files.atomic import write_bytes, writing

FLASH = 32_767  # bytes, the longest array on an AVR, which addresses it with 16 bits
JOINTS = 255
LONGEST_NAME = 63  # characters of a sketch's name
RAMP_SPEED = 60.0  # °/s, mean speed of the ramps between standing and the gait
RAMP_SHARE = 0.5  # of a servo's speed: the middle of a ramp is 1.5 times as fast as its mean
_HEADER = """\
// The gait for {name}.ino: servo pulses in microseconds. Written by gaitsim.
#pragma once
#include <Arduino.h>

const uint8_t JOINTS = {joints};
const uint8_t BOARDS = {boards};
const uint16_t KEYFRAMES = {keyframes};
const uint16_t LOOP_FROM = {loop};  // the keyframe that follows the last one{loop_comment}
const uint32_t KEYFRAME_US = {interval};  // time between keyframes

// Joints: {names}
const uint8_t SERVO_BOARD[JOINTS] PROGMEM = {{{board}}};
const uint8_t SERVO_CHANNEL[JOINTS] PROGMEM = {{{channel}}};
const uint16_t STANDING[JOINTS] PROGMEM = {{{standing}}};
const uint16_t LOWEST[JOINTS] PROGMEM = {{{lowest}}};
const uint16_t HIGHEST[JOINTS] PROGMEM = {{{highest}}};
const uint16_t RAMP[JOINTS] PROGMEM = {{{ramp}}};  // mean speed of ramps, us/s

const uint16_t GAIT[KEYFRAMES][JOINTS] PROGMEM = {{
{rows}
}};
"""


@dataclass(frozen=True)
class Sketch:
    """The two files of a sketch.

    Attributes:
        name: name of the sketch, its folder and its .ino file.
        program: text of the .ino file.
        header: text of gait.h.
        flash: size of the gait in flash, bytes.
        boards: number of PCA9685 boards.
    """

    name: str
    program: str
    header: str
    flash: int
    boards: int


def sketch_of(keyframes: Keyframes, calibration: Calibration, name: str, title: str) -> Sketch:
    """Return a sketch that plays keyframes.

    Args:
        keyframes: keyframes of the gait.
        calibration: calibration of its joints, each with a channel.
        name: name of the sketch.
        title: title of the gait, one line of text.

    Raises:
        GaitsimError: the gait does not fit into the flash or has too many joints, or its standing
            pose is beyond the limits.
    """
    count, joints = keyframes.degrees.shape
    flash = count * joints * 2
    if flash > FLASH:
        interval = np.ceil(keyframes.interval * 1000 * flash / FLASH)
        raise GaitsimError(
            f"{count:,} keyframes of {joints} joints take {flash:,} bytes of flash",
            where="--format arduino",
            allowed=f"{FLASH:,} bytes",
            remedy=f"use fewer keyframes, with --keyframe-ms {interval:.0f}",
        )
    if joints > JOINTS:
        raise GaitsimError(f"the gait has {joints} joints", allowed=f"at most {JOINTS}")
    _check_standing(keyframes, calibration)
    servos = [*calibration.joints.values()]
    boards = 1 + max(servo.board for servo in servos)
    looped = keyframes.loop_from is not None
    header = _HEADER.format(
        name=name,
        joints=joints,
        boards=boards,
        keyframes=count,
        loop=keyframes.loop_from if looped else "KEYFRAMES",
        loop_comment="" if looped else ": none, the gait is played once",
        interval=round(keyframes.interval * 1e6),
        names=", ".join(_comment(name) for name in keyframes.joint_names),
        board=_list([servo.board for servo in servos]),
        channel=_list([servo.channel for servo in servos]),
        standing=_list(_whole(calibration.pulses(keyframes.standing))),
        # Rounding a limit to 0.01° changes its pulse by less than 1 µs.
        lowest=_list(_whole(calibration.pulses(calibration.low))),
        highest=_list(_whole(calibration.pulses(calibration.high))),
        ramp=_list(_whole(_ramps(calibration))),
        rows="\n".join(
            f"  {{{_list(row)}}}," for row in _whole(calibration.pulses(keyframes.degrees))
        ),
    )
    addresses = [f"0x{0x40 + board:02x}" for board in range(boards)]
    program = (files("gaitsim.hardware") / "sketch.ino").read_text(encoding="utf-8")
    text = f"PCA9685 board{'s' * (boards > 1)} {', '.join(addresses)}"
    made = [f"  Adafruit_PWMServoDriver({address})," for address in addresses]
    for mark, put in (
        ("@BOARDS_TEXT@", text),
        ("@BOARDS@", "\n".join(made)),
        ("@TITLE@", _comment(title)),  # last, as a title may contain the other marks
    ):
        program = program.replace(mark, put)
    return Sketch(name, program, header, flash, boards)


def write_sketch(sketch: Sketch, folder: Path) -> None:
    """Write the sketch as a folder with two files, replacing those of an earlier sketch.

    Raises:
        RunError: the folder or a file cannot be written.
    """
    check_parent(folder)
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise RunError(
            f"cannot write {folder}: it is not a folder",
            remedy="choose a new folder with --out",
        )
    with writing(folder):
        folder.mkdir(exist_ok=True)
    write_bytes(folder / "gait.h", sketch.header.encode(), follow=False)
    write_bytes(folder / f"{sketch.name}.ino", sketch.program.encode(), follow=False)


def sketch_name(folder: Path) -> str:
    """Return the name of the sketch in a folder, which the Arduino IDE requires to be the same.

    Raises:
        GaitsimError: the folder's name is not allowed for a sketch.
    """
    name = folder.name
    if not (name.isascii() and name.replace("_", "").isalnum() and len(name) <= LONGEST_NAME):
        raise GaitsimError(
            f"invalid name {name!r} of an Arduino sketch",
            where="--out",
            allowed=f"letters, digits and _, at most {LONGEST_NAME}",
        )
    return name


def _check_standing(keyframes: Keyframes, calibration: Calibration) -> None:
    """Check that the standing pose, in which a sketch starts, is within the limits."""
    standing = np.round(keyframes.standing, DECIMALS)
    excess = calibration.excess(standing)
    joint = int(excess.argmax())
    if excess[joint] > 0:
        raise beyond_range(calibration, joint, standing[joint], "in the standing pose")


def _ramps(calibration: Calibration) -> NDArray[np.float64]:
    """Return the mean speed of each servo in ramps, µs/s."""
    degrees = np.minimum(RAMP_SPEED, calibration.fastest * RAMP_SHARE)
    pulses: NDArray[np.float64] = calibration.pulses(degrees) - calibration.pulses(0 * degrees)
    return np.maximum(pulses, 1)


def _whole(values: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.rint(values).astype(np.int64)


def _list(values: object) -> str:
    return ", ".join(str(value) for value in np.asarray(values).tolist())


def _comment(text: str) -> str:
    """Return a text without characters that could end its comment."""
    return "".join(char if char.isprintable() and char != "\\" else "?" for char in text)
