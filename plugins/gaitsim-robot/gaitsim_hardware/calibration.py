"""Calibrations: the servo of each joint, with its direction, offset and limits."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, field_validator, model_validator

from gaitsim.plugin import GaitsimError, nearest, option
from gaitsim.plugin.toolkit import SERVOS, Servo

Floats = NDArray[np.float64]

CHANNELS = 16  # outputs of a PCA9685 board
BOARDS = 16  # addresses 0x40 to 0x4f
HALF_RANGE = 90.0  # °, largest angle from the centre by default; `pulse` is given for ±90°
PULSE = (600, 2400)  # µs at −90° and 90°, typical of hobby servos
BUSES: Mapping[str, str] = {"arduino": "pwm", "dynamixel": "dynamixel", "feetech": "feetech"}
DEFAULT_SERVOS: Mapping[str, str] = {"dynamixel": "xl430-w250", "feetech": "sts3215"}


class Joint(BaseModel):
    """The servo of one joint. Angles are in degrees from the servo's centre."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    board: int = option(0, "PCA9685 board: 0 at 0x40, 1 at 0x41, …", ge=0, lt=BOARDS)
    channel: int | None = option(None, "output of the board", ge=0, lt=CHANNELS)
    id: int | None = option(None, "id of the servo on its bus", ge=0, le=252)
    direction: Literal[-1, 1] = option(
        1, "direction of the servo: −1 if it turns opposite to the joint, otherwise 1"
    )
    offset: float = option(
        0.0, "angle of the servo when the joint is at zero", unit="°", ge=-360, le=360
    )
    min: float = option(-HALF_RANGE, "smallest angle of the servo", unit="°", ge=-360, le=360)
    max: float = option(HALF_RANGE, "largest angle of the servo", unit="°", ge=-360, le=360)
    pulse: tuple[int, int] = option(
        PULSE, "pulse widths at −90° and at 90° of the servo", unit="µs"
    )
    servo: str = option("", f"model of the servo, with known ticks and speed: {', '.join(SERVOS)}")
    speed: float | None = option(
        None, "largest speed of the servo, instead of the model's", unit="°/s", gt=0, le=10_000
    )

    @field_validator("servo")
    @classmethod
    def _check_servo(cls, name: str) -> str:
        if name and name not in SERVOS:
            hint = nearest(name, [*SERVOS])
            raise ValueError(
                f"unknown servo; choose from {', '.join(SERVOS)}" + (f"; {hint}" if hint else "")
            )
        return name

    @field_validator("pulse")
    @classmethod
    def _check_pulse(cls, pulse: tuple[int, int]) -> tuple[int, int]:
        if not 100 <= pulse[0] < pulse[1] <= 3500:
            raise ValueError("expected two pulses from 100 to 3500 µs, the shorter first")
        return pulse

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if not self.min < self.max:
            raise ValueError(f"'min', {self.min:g}, is not less than 'max', {self.max:g}")
        servo = self.model
        if servo and not (-self._range(servo)[0] <= self.min and self.max <= self._range(servo)[1]):
            low, high = self._range(servo)
            raise ValueError(
                f"{self.min:g}° to {self.max:g}° exceeds the range of the servo {servo.name!r}, "
                f"{-low:.2f}° to {high:.2f}°"
            )
        return self

    @property
    def model(self) -> Servo | None:
        """Model of the servo; None if it is unknown."""
        return SERVOS.get(self.servo)

    @property
    def max_speed(self) -> float:
        """Largest speed of the servo, °/s; infinite if it is unknown."""
        if self.speed is not None:
            return self.speed
        return math.degrees(self.model.no_load_speed) if self.model else math.inf

    @staticmethod
    def _range(servo: Servo) -> tuple[float, float]:
        """Return how far a servo can turn below and above its centre, °."""
        half = math.degrees(servo.travel / 2)
        high = math.degrees(servo.tick * (servo.ticks - 1)) - half if servo.ticks else half
        return half + 1e-6, high + 1e-6


@dataclass(frozen=True, eq=False)
class Calibration:
    """The servos of a robot.

    Attributes:
        joints: servo of each joint by the joint's name, in the order of the gait.
        source: file of the calibration; '' for a default.
        limited_by: phrase that names the place where a user sets the ranges, for messages.
        ends: both ends of each joint in the model, (joints, 2) rad; None if they are unknown.
    """

    joints: Mapping[str, Joint]
    source: str = ""
    limited_by: str = "in a calibration file (--calibration-template writes one)"
    ends: Floats | None = None

    def servo_angles(self, angles: Floats) -> Floats:
        """Convert joint angles, (…, joints) rad, to servo angles, °."""
        turned: Floats = np.degrees(angles) * self._values("direction") + self._values("offset")
        return turned

    @property
    def same_as_joints(self) -> bool:
        """Whether the angles of all servos are those of their joints."""
        return all(one.offset == 0 and one.direction == 1 for one in self.joints.values())

    def joint_angles(self, degrees: Floats) -> Floats:
        """Convert servo angles, (…, joints) °, to joint angles, rad."""
        turned: Floats = (degrees - self._values("offset")) * self._values("direction")
        return np.radians(turned)

    @cached_property
    def low(self) -> Floats:
        """Smallest angle of each servo, (joints,) °."""
        return self._values("min")

    @cached_property
    def high(self) -> Floats:
        """Largest angle of each servo, (joints,) °."""
        return self._values("max")

    @cached_property
    def max_speeds(self) -> Floats:
        """Largest speed of each servo, (joints,) °/s; infinite if it is unknown."""
        return self._values("max_speed")

    def excess(self, degrees: Floats) -> Floats:
        """Return how far servo angles, (…, joints) °, exceed their ranges; ≤ 0 within them."""
        return np.maximum(self.low - degrees, degrees - self.high)

    def pulses(self, degrees: Floats) -> Floats:
        """Convert servo angles, (…, joints) °, to pulses, µs."""
        short, long = self._pulses
        pulses: Floats = short + (degrees + HALF_RANGE) / (2 * HALF_RANGE) * (long - short)
        return pulses

    def angles_of_pulses(self, pulses: Floats) -> Floats:
        """Convert pulses, (…, joints) µs, to servo angles, °."""
        short, long = self._pulses
        degrees: Floats = (pulses - short) / (long - short) * 2 * HALF_RANGE - HALF_RANGE
        return degrees

    @cached_property
    def _pulses(self) -> Floats:
        """Pulses at −90° and 90° of each servo, (2, joints) µs."""
        return np.array([joint.pulse for joint in self.joints.values()], np.float64).T

    def ticks(self, degrees: Floats) -> NDArray[np.int64]:
        """Convert angles of servos on a bus, (…, joints) °, to the nearest goal positions.

        Positions beyond a servo's range are clipped.
        """
        tick, centre, ticks = self._ticks
        positions = np.rint(centre + np.radians(degrees) / tick).astype(np.int64)
        clipped: NDArray[np.int64] = np.clip(positions, 0, ticks.astype(np.int64) - 1)
        return clipped

    def angles_of_ticks(self, positions: Floats | NDArray[np.int64]) -> Floats:
        """Convert positions of servos on a bus, (…, joints), to servo angles, °."""
        tick, centre, _ = self._ticks
        degrees: Floats = np.degrees((positions - centre) * tick)
        return degrees

    @cached_property
    def _ticks(self) -> Floats:
        """Angle of a position in rad, central position, and number of positions, (3, joints)."""
        servos = [joint.model for joint in self.joints.values()]
        return np.array([[one.tick, one.centre_tick, one.ticks] for one in servos if one]).T

    def _values(self, name: str) -> Floats:
        return np.array([getattr(joint, name) for joint in self.joints.values()], np.float64)


def default_calibration(
    format: str, joints: Sequence[str], standing: Floats, servo: str = ""
) -> Calibration:
    """Return a calibration for servos that are centred in the standing pose.

    Args:
        format: 'arduino', 'dynamixel' or 'feetech'.
        joints: names of the joints, in the order of their channels (from 0) or ids (from 1).
        standing: joint angles in the standing pose, (joints,) rad.
        servo: name of the simulated robot's servo. It is used if the format can drive it.
    """
    known = SERVOS.get(servo)
    name = servo if known and known.bus == BUSES[format] else DEFAULT_SERVOS.get(format, "")
    found = SERVOS.get(name)
    below, above = Joint._range(found) if found else (HALF_RANGE, HALF_RANGE)
    on_board = format == "arduino"
    return Calibration(
        {
            joint: Joint(
                board=index // CHANNELS % BOARDS if on_board else 0,
                channel=index % CHANNELS if on_board else None,
                id=None if on_board else index + 1,
                offset=round(-angle, 2) + 0.0,
                min=_truncated(-below),
                max=_truncated(above),
                servo=name,
            )
            for index, (joint, angle) in enumerate(
                zip(joints, np.degrees(standing).tolist(), strict=True)
            )
        }
    )


def _truncated(bound: float) -> float:
    """Round a bound towards 0, to 0.01°."""
    return math.trunc(bound * 100) / 100


def uniform_calibration(
    joints: Sequence[str], centre: float, low: float, high: float
) -> Calibration:
    """Return a calibration with the same centre and limits, in °, for all joints."""
    if not -np.inf < low < high < np.inf or not low <= centre <= high:
        raise GaitsimError(
            f"invalid servo range from {low:g}° to {high:g}° with the centre at {centre:g}°",
            where="--min, --max, --centre",
            allowed="min < max, and the centre between them",
        )
    # The angles depend on the user's controller, so they are not validated.
    joint = Joint.model_construct(offset=centre, min=low, max=high)
    return Calibration(dict.fromkeys(joints, joint), limited_by="with --min and --max")
