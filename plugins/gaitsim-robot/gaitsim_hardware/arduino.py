"""Gaits as Arduino sketches for hobby servos on PCA9685 boards."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Controller, GaitsimError
from gaitsim.plugin.runs import write_bytes, writing
from gaitsim_hardware.c_code import as_comment, c_code, filled, make_folder
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
_SERVOS = """\
// The servos of {name}.ino. Written by gaitsim.
#pragma once
#include <Arduino.h>

const uint8_t BOARDS = {boards};

// Joints: {names}
const uint8_t SERVO_BOARD[] = {{{board}}};
const uint8_t SERVO_CHANNEL[] = {{{channel}}};
const float ZERO_US[] = {{{zero}}};  // pulse for a joint angle of 0
const float US_PER_RADIAN[] = {{{slope}}};
const uint16_t LOWEST[] = {{{lowest}}};  // us
const uint16_t HIGHEST[] = {{{highest}}};
"""
_RECEIVER = """\
// The servos of {name}.ino. Written by gaitsim.
#pragma once
#include <Arduino.h>

const uint8_t JOINTS = {joints};
const uint8_t BOARDS = {boards};
const uint32_t SERVOS = 0x{checksum:08x};  // checksum of this file

// Joints: {names}
const uint8_t SERVO_BOARD[] = {{{board}}};
const uint8_t SERVO_CHANNEL[] = {{{channel}}};
const uint16_t LOWEST[] = {{{lowest}}};  // us
const uint16_t HIGHEST[] = {{{highest}}};
"""


@dataclass(frozen=True)
class Sketch:
    """The files of a sketch.

    Attributes:
        files: text of each file by name.
        flash: size of the gait in flash, bytes.
        boards: number of PCA9685 boards.
    """

    files: Mapping[str, str]
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
    check_standing(np.round(keyframes.standing, DECIMALS), calibration)
    boards = count_boards(calibration)
    looped = keyframes.loop_from is not None
    header = _HEADER.format(
        name=name,
        joints=joints,
        keyframes=count,
        loop=keyframes.loop_from if looped else "KEYFRAMES",
        loop_comment="" if looped else ": none, the gait is played once",
        interval=round(keyframes.interval * 1e6),
        standing=_join(_rounded(calibration.pulses(keyframes.standing))),
        ramp=_join(_rounded(_ramp_speeds(calibration))),
        rows="\n".join(
            f"  {{{_join(row)}}}," for row in _rounded(calibration.pulses(keyframes.degrees))
        ),
        **_servo_texts(calibration),
    )
    program = filled("sketch.ino", {**_board_texts(boards), "TITLE": as_comment(title)})
    return Sketch({f"{name}.ino": program, "gait.h": header}, flash, boards)


def create_controller_sketch(
    controller: Controller, calibration: Calibration, name: str, title: str
) -> Sketch:
    """Create a sketch that follows commands, with reflexes.

    Args:
        controller: rhythm and reflexes of the gait.
        calibration: calibration of its joints, each with a channel.
        name: name of the sketch.
        title: title of the gait, one line.
    """
    rhythm, boards = controller.rhythm, count_boards(calibration)
    code = c_code(controller, title)
    zero = calibration.pulses(calibration.servo_angles(0 * rhythm.standing))
    one = calibration.pulses(calibration.servo_angles(0 * rhythm.standing + 1))
    header = _SERVOS.format(
        name=name,
        zero=_join(np.round(zero, 2)),
        slope=_join(np.round(one - zero, 2)),
        **_servo_texts(calibration),
    )
    texts = {
        **_board_texts(boards),
        "LEGS_TEXT": ", ".join(map(as_comment, rhythm.names)),
        "PINS": _join([-1] * len(rhythm.names)),
        "SENSOR": filled("sensor.ino", {}),
        "TITLE": as_comment(title),
    }
    texts = {
        f"{name}.ino": filled("controller.ino", texts),
        "servos.h": header,
        "gait.h": code.header,
        "gait.c": code.source,
    }
    return Sketch(texts, code.tables, boards)


def create_receiver_sketch(calibration: Calibration, name: str, title: str) -> Sketch:
    """Create a sketch that plays pulses that a program sends.

    Args:
        calibration: calibration of the joints, each with a channel.
        name: name of the sketch.
        title: title of the robot, one line.
    """
    texts = {"SENSOR": filled("sensor.ino", {}), "TITLE": as_comment(title)}
    boards, servos = count_boards(calibration), _servo_texts(calibration)
    header = _RECEIVER.format(
        name=name, joints=len(calibration.joints), checksum=servo_checksum(calibration), **servos
    )
    program = filled("receiver.ino", {**_board_texts(boards), **texts})
    return Sketch({f"{name}.ino": program, "servos.h": header}, 0, boards)


def write_sketch(sketch: Sketch, folder: Path) -> None:
    """Write the files of a sketch to a folder, and replace the files of an earlier sketch."""
    make_folder(folder)
    for name, text in sketch.files.items():
        write_bytes(folder / name, text.encode(), follow=False)
    for name in {"gait.h", "gait.c", "servos.h"} - {*sketch.files}:
        with writing(folder / name):
            (folder / name).unlink(missing_ok=True)  # Arduino compiles all files of the folder


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


def check_standing(degrees: NDArray[np.float64], calibration: Calibration) -> None:
    """Raise an error if the standing pose, in which a sketch starts, is beyond the limits."""
    excess = calibration.excess(degrees)
    joint = int(excess.argmax())
    if excess[joint] > 0:
        raise range_error(calibration, joint, degrees[joint], "in the standing pose")


def count_boards(calibration: Calibration) -> int:
    """Return the number of PCA9685 boards."""
    return 1 + max(servo.board for servo in calibration.joints.values())


def _servo_texts(calibration: Calibration) -> dict[str, str]:
    """Return the placeholders of a header for its servos."""
    servos = calibration.joints.values()
    if len(servos) > MAX_JOINTS:
        raise GaitsimError(f"the gait has {len(servos)} joints", allowed=f"at most {MAX_JOINTS}")
    return {
        "boards": str(count_boards(calibration)),
        "names": ", ".join(map(as_comment, calibration.joints)),
        "board": _join([servo.board for servo in servos]),
        "channel": _join([servo.channel for servo in servos]),
        # Rounding a limit to 0.01° changes its pulse by less than 1 µs.
        "lowest": _join(_rounded(calibration.pulses(calibration.low))),
        "highest": _join(_rounded(calibration.pulses(calibration.high))),
    }


def servo_checksum(calibration: Calibration) -> int:
    """Return a CRC-32 of the outputs and limits of the servos in a sketch."""
    return zlib.crc32(repr(sorted(_servo_texts(calibration).items())).encode())


def _board_texts(boards: int) -> dict[str, str]:
    """Return the placeholders of a sketch for its boards."""
    addresses = [f"0x{0x40 + board:02x}" for board in range(boards)]
    return {
        "BOARDS_TEXT": f"PCA9685 board{'s' * (boards > 1)} {', '.join(addresses)}",
        "BOARDS": "\n".join(f"  Adafruit_PWMServoDriver({address})," for address in addresses),
    }


def _ramp_speeds(calibration: Calibration) -> NDArray[np.float64]:
    """Return the mean speed of each servo in ramps, µs/s."""
    degrees = np.minimum(RAMP_SPEED, calibration.max_speeds * RAMP_SHARE)
    pulses: NDArray[np.float64] = calibration.pulses(degrees) - calibration.pulses(0 * degrees)
    return np.maximum(pulses, 1)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.rint(values).astype(np.int64)


def _join(values: object) -> str:
    return ", ".join(str(value) for value in np.asarray(values).tolist())
