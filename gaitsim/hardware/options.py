"""The formats for robots, and what each of them takes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from gaitsim.choices import GaitFormat, RosFormat, ServoFormat
from gaitsim.errors import GaitsimError

ENDINGS = {
    **{format: f".{format}" for format in get_args(GaitFormat)},
    "servo": ".servo.csv",
    "arduino": "",  # a folder
    "dynamixel": ".dynamixel.csv",
    "feetech": ".feetech.csv",
    "ros2": ".yaml",
    "rosbag2": "",  # a folder
}
"""The end of a default file name by format."""


@dataclass(frozen=True)
class Options:
    """How a gait is exported.

    Attributes:
        calibration: a TOML file; None for servos at their centre as the robot stands.
        keyframe_ms: time from one keyframe to the next; None for that of the frames.
        speed: of playback; None for 1, as simulated.
        clip: whether to clip angles beyond the limits rather than refuse them.
        centre, low, high: ° of a servo table; None for 0 and 90° to either side of the centre.
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
        """The speed of playback."""
        return 1.0 if self.speed is None else self.speed

    def flags(self) -> list[str]:
        """Return the options that are given, as on the command line."""
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
TAKES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(get_args(GaitFormat), ()),
    **dict.fromkeys(get_args(RosFormat), ("--keyframe-ms", "--speed")),
    **dict.fromkeys(get_args(ServoFormat), _SERVO),
    "servo": (*_SERVO, "--centre", "--min", "--max"),
}
"""The flags of `Options` that a format takes."""


def refuse_options(
    format: str, given: Iterable[str], takes: Mapping[str, tuple[str, ...]] = TAKES
) -> None:
    """Refuse flags that a format does not take.

    Args:
        format: one of `takes`.
        given: the flags, as on the command line.
        takes: the flags that each format takes.

    Raises:
        GaitsimError: there are some.
    """
    idle = [name for name in given if name not in takes[format]]
    if idle:
        takers = [other for other, taken in takes.items() if set(idle) <= set(taken)]
        raise GaitsimError(
            f"the format {format} does not take {' and '.join(idle)}",
            where="--format",
            allowed=f"{', '.join(takers) or 'none'}, with these options",
        )


def check_options(format: str, options: Options) -> None:
    """Refuse options that a format does not take, or that contradict each other.

    Raises:
        GaitsimError: there are some.
    """
    refuse_options(format, options.flags())
    uniform = [name for name in options.flags() if name in ("--centre", "--min", "--max")]
    if options.calibration and uniform:
        raise GaitsimError(
            f"--calibration has the ranges of the servos, so it does not go with "
            f"{' and '.join(uniform)}",
            remedy="leave one of the two out",
        )
