"""Formats of gait exports, and the options that each of them accepts."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from gaitsim.choices import GaitFormat, RosFormat, ServoFormat
from gaitsim.errors import GaitsimError, unsupported_flags

ENDINGS = {
    **{format: f".{format}" for format in get_args(GaitFormat)},
    "servo": ".servo.csv",
    "arduino": "",  # a folder
    "dynamixel": ".dynamixel.csv",
    "feetech": ".feetech.csv",
    "ros2": ".yaml",
    "rosbag2": "",  # a folder
}
"""Suffix of the default file name by format."""


@dataclass(frozen=True)
class Options:
    """The options of an export.

    Attributes:
        calibration: TOML file of the calibration; None for servos that are centred in the standing
            pose.
        keyframe_ms: time between keyframes, ms; None for one keyframe per frame.
        speed: speed of playback; None for 1, the simulated speed.
        clip: whether to clip angles beyond the limits instead of raising an error.
        centre: angle of a servo in a servo table when its joint is at zero, °; None for 0.
        low: smallest angle in a servo table, °; None for 90° below the centre.
        high: largest angle in a servo table, °; None for 90° above the centre.
    """

    calibration: Path | None = None
    keyframe_ms: int | None = None
    speed: float | None = None
    clip: bool = False
    centre: float | None = None
    low: float | None = None
    high: float | None = None

    @property
    def playback(self) -> float:
        """Speed of playback, 1 by default."""
        return 1.0 if self.speed is None else self.speed

    def flags(self) -> list[str]:
        """Return the command-line flags of the options that are set."""
        given = {
            "--calibration": self.calibration,
            "--keyframe-ms": self.keyframe_ms,
            "--speed": self.speed,
            "--clip": self.clip or None,
            "--centre": self.centre,
            "--min": self.low,
            "--max": self.high,
        }
        return [name for name, value in given.items() if value is not None]


_SERVO = ("--calibration", "--keyframe-ms", "--speed", "--clip")
ACCEPTED_FLAGS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(get_args(GaitFormat), ()),
    **dict.fromkeys(get_args(RosFormat), ("--keyframe-ms", "--speed")),
    **dict.fromkeys(get_args(ServoFormat), _SERVO),
    "servo": (*_SERVO, "--centre", "--min", "--max"),
}
"""Flags that each format accepts."""


def check_accepted_flags(
    format: str, given: Iterable[str], accepted: Mapping[str, tuple[str, ...]] = ACCEPTED_FLAGS
) -> None:
    """Raise an error for flags that a format does not accept.

    Args:
        format: a key of `accepted`.
        given: flags, as on the command line.
        accepted: flags that each format accepts.
    """
    rejected = [name for name in given if name not in accepted[format]]
    if rejected:
        formats = [name for name, flags in accepted.items() if set(rejected) <= set(flags)]
        subject = f"the format {format!r}"
        raise unsupported_flags(subject, rejected, "--format", formats, where="--format")


def check_options(format: str, options: Options) -> None:
    """Raise an error for options that a format does not accept or that conflict."""
    check_accepted_flags(format, options.flags())
    uniform = [name for name in options.flags() if name in ("--centre", "--min", "--max")]
    if options.calibration and uniform:
        raise GaitsimError(
            f"--calibration sets the ranges of the servos, so it cannot be combined with "
            f"{' and '.join(uniform)}",
            remedy=f"set the ranges in the calibration, and omit {' and '.join(uniform)}",
        )
