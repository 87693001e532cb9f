"""Gaits as Arduino sketches for hobby servos on PCA9685 boards."""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait.gait_files import check_parent
from gaitsim.runs.files.atomic import write_bytes, writing
from gaitsim_hardware.calibration import Calibration
from gaitsim_hardware.keyframes import DECIMALS, Keyframes, range_error

FLASH = 32_767  # bytes, the longest array on an AVR, which addresses it with 16 bits
MAX_JOINTS = 255
MAX_NAME = 63  # characters
RAMP_SPEED = 60.0  # °/s, mean speed of the ramps between standing and the gait
RAMP_SHARE = 0.5  # largest mean speed of a ramp / servo speed; the peak is 1.5 times the mean
_HEADER = """\
// The gait for {name}.ino: servo pulses in microseconds. Written by gaitsim.
#pragma once
#include <Arduino.h>

const uint8_t JOINTS = {joints};
const uint8_t BOARDS = {boards};
const uint16_t KEYFRAMES = {keyframes};
const uint16_t LOOP_FROM = {loop};  // keyframe that follows the last one{loop_comment}
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


def create_sketch(keyframes: Keyframes, calibration: Calibration, name: str, title: str) -> Sketch:
    """Create a sketch that plays keyframes.

    Args:
        keyframes: keyframes of the gait.
        calibration: calibration of its joints, each with a channel.
        name: name of the sketch.
        title: title of the gait, one line.
    """
    count, joints = keyframes.degrees.shape
    flash = count * joints * 2
    if flash > FLASH:
        interval = np.ceil(keyframes.interval * 1000 * flash / FLASH)
        raise GaitsimError(
            f"{count:,} keyframes of {joints} joints take {flash:,} bytes of flash",
            where="--format arduino",
            allowed=f"at most {FLASH:,} bytes",
            remedy=f"use fewer keyframes, with --keyframe-ms {interval:.0f}",
        )
    if joints > MAX_JOINTS:
        raise GaitsimError(f"the gait has {joints} joints", allowed=f"at most {MAX_JOINTS}")
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
        names=", ".join(_escape_comment(name) for name in keyframes.joint_names),
        board=_join([servo.board for servo in servos]),
        channel=_join([servo.channel for servo in servos]),
        standing=_join(_rounded(calibration.pulses(keyframes.standing))),
        # Rounding a limit to 0.01° changes its pulse by less than 1 µs.
        lowest=_join(_rounded(calibration.pulses(calibration.low))),
        highest=_join(_rounded(calibration.pulses(calibration.high))),
        ramp=_join(_rounded(_ramp_speeds(calibration))),
        rows="\n".join(
            f"  {{{_join(row)}}}," for row in _rounded(calibration.pulses(keyframes.degrees))
        ),
    )
    addresses = [f"0x{0x40 + board:02x}" for board in range(boards)]
    program = (files("gaitsim_hardware") / "sketch.ino").read_text(encoding="utf-8")
    text = f"PCA9685 board{'s' * (boards > 1)} {', '.join(addresses)}"
    drivers = [f"  Adafruit_PWMServoDriver({address})," for address in addresses]
    for placeholder, value in (
        ("@BOARDS_TEXT@", text),
        ("@BOARDS@", "\n".join(drivers)),
        ("@TITLE@", _escape_comment(title)),  # last, as a title may contain other placeholders
    ):
        program = program.replace(placeholder, value)
    return Sketch(name, program, header, flash, boards)


def write_sketch(sketch: Sketch, folder: Path) -> None:
    """Write the two files of a sketch to a folder, and replace the files of an earlier sketch."""
    check_parent(folder)
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise RunError(
            f"cannot write {folder}: it is not a folder",
            remedy="choose a different folder with --out",
        )
    with writing(folder):
        folder.mkdir(exist_ok=True)
    write_bytes(folder / "gait.h", sketch.header.encode(), follow=False)
    write_bytes(folder / f"{sketch.name}.ino", sketch.program.encode(), follow=False)


def sketch_name(folder: Path) -> str:
    """Return the name of the sketch in a folder.

    The Arduino IDE requires the sketch and its folder to have the same name.
    """
    name = folder.name
    if not (name.isascii() and name.replace("_", "").isalnum() and len(name) <= MAX_NAME):
        raise GaitsimError(
            f"invalid name for an Arduino sketch: {name!r}",
            where="--out",
            allowed=f"at most {MAX_NAME} letters, digits and underscores",
        )
    return name


def _check_standing(keyframes: Keyframes, calibration: Calibration) -> None:
    """Raise an error if the standing pose, in which a sketch starts, is beyond the limits."""
    standing = np.round(keyframes.standing, DECIMALS)
    excess = calibration.excess(standing)
    joint = int(excess.argmax())
    if excess[joint] > 0:
        raise range_error(calibration, joint, standing[joint], "in the standing pose")


def _ramp_speeds(calibration: Calibration) -> NDArray[np.float64]:
    """Return the mean speed of each servo in ramps, µs/s."""
    degrees = np.minimum(RAMP_SPEED, calibration.max_speeds * RAMP_SHARE)
    pulses: NDArray[np.float64] = calibration.pulses(degrees) - calibration.pulses(0 * degrees)
    return np.maximum(pulses, 1)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.rint(values).astype(np.int64)


def _join(values: object) -> str:
    return ", ".join(str(value) for value in np.asarray(values).tolist())


def _escape_comment(text: str) -> str:
    """Replace the characters of a text that could end its comment."""
    return "".join(char if char.isprintable() and char != "\\" else "?" for char in text)
