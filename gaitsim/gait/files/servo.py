"""Tables of keyframes for hobby servos: times in milliseconds, angles in degrees."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.files.writer import Gait, check_folder
from gaitsim.runs.files.atomic import write_bytes

REACH = 90.0  # degrees to either side of the centre: what a hobby servo turns
DECIMALS = 2  # of a degree; the steps of a hobby servo are ten times as wide


@dataclass(frozen=True)
class ServoRange:
    """The range of a robot's servos, degrees.

    Attributes:
        centre: the angle of the pose at rest.
        low: the smallest angle.
        high: the largest angle.

    Raises:
        GaitsimError: they are not in order.
    """

    centre: float = 0.0
    low: float = -REACH
    high: float = REACH

    @classmethod
    def around(cls, centre: float, low: float | None, high: float | None) -> Self:
        """Return a range whose limits default to 90° on either side of the centre."""
        return cls(
            centre,
            centre - REACH if low is None else low,
            centre + REACH if high is None else high,
        )

    def __post_init__(self) -> None:
        if not -np.inf < self.low < self.high < np.inf or not self.low <= self.centre <= self.high:
            raise GaitsimError(
                f"servos cannot turn from {self.low:g}° to {self.high:g}° with {self.centre:g}° "
                "for the pose at rest",
                where="--min, --max, --centre",
                allowed="min < max, and the centre between them",
            )


@dataclass(frozen=True, eq=False)
class ServoTable:
    """Keyframes for servos.

    Attributes:
        milliseconds: of each keyframe, (keyframes,) int64, from 0.
        degrees: angle of each servo, (keyframes, joints) float64.
        joint_names: name of each joint.
        clipped: number of angles that were clipped to the range.
        off: the largest distance, degrees, between the gait and straight lines from one
            keyframe to the next.
    """

    milliseconds: NDArray[np.int64]
    degrees: NDArray[np.float64]
    joint_names: tuple[str, ...]
    clipped: int
    off: float


def servo_table(
    gait: Gait, servos: ServoRange, keyframe_ms: int | None = None, *, clip: bool = False
) -> ServoTable:
    """Return the keyframes of a gait.

    Args:
        gait: the joint angles; zero is the pose at rest.
        servos: their range.
        keyframe_ms: time from one keyframe to the next, in which the gait is interpolated;
            None takes every frame of the gait, at the nearest millisecond.
        clip: whether to clip angles beyond the range rather than refuse them.

    Raises:
        GaitsimError: an angle is beyond the range, or there are not two keyframes.
    """
    frames = np.arange(len(gait.angles)) * (1000 / gait.frame_rate)
    angles = np.degrees(gait.angles)
    if keyframe_ms is None:
        times, keys = np.rint(frames).astype(np.int64), angles
    else:
        # Half a millionth of a millisecond more, as the last frame's time is rounded.
        times = np.arange(0, frames[-1] + 5e-7, keyframe_ms).astype(np.int64)
        keys = _between(times, frames, angles)
    if len(times) < 2 or (np.diff(times) == 0).any():
        raise GaitsimError(
            f"a gait of {frames[-1]:g} ms gives {len(times)} keyframes, which are no movement",
            where="" if keyframe_ms is None else f"--keyframe-ms {keyframe_ms}",
            allowed="two keyframes or more, at least 1 ms apart",
        )
    sent = np.round(keys + servos.centre, DECIMALS) + 0.0  # no −0.0
    beyond = (sent < servos.low) | (sent > servos.high)
    if beyond.any() and not clip:
        raise _refused(gait, servos, times, sent)
    held = np.clip(sent, servos.low, servos.high)
    played = _between(frames, times, held)
    inside = frames <= times[-1]
    off = float(np.abs(played - servos.centre - angles)[inside].max())
    return ServoTable(times, held, gait.joint_names, int(beyond.sum()), off)


def write_servo(table: ServoTable, path: Path) -> None:
    """Write keyframes atomically as CSV: a column `time_ms`, then one a joint, degrees.

    Raises:
        RunError: it cannot be written.
    """
    check_folder(path)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_ms", *table.joint_names])
    for time, row in zip(table.milliseconds.tolist(), table.degrees.tolist(), strict=True):
        writer.writerow([time, *(f"{angle:.{DECIMALS}f}" for angle in row)])
    write_bytes(path, text.getvalue().encode())


def _between(
    times: NDArray[Any],
    known: NDArray[Any],
    angles: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Interpolate the angles at `times` linearly between those at `known`, (times, joints)."""
    return np.stack([np.interp(times, known, column) for column in angles.T], axis=1)


def _refused(
    gait: Gait, servos: ServoRange, times: NDArray[np.int64], sent: NDArray[np.float64]
) -> GaitsimError:
    """Return the error of the angle that is farthest beyond the range."""
    excess = np.maximum(servos.low - sent, sent - servos.high)
    keyframe, joint = np.unravel_index(np.argmax(excess), excess.shape)
    joints = int((excess > 0).any(axis=0).sum())
    others = f", and {joints - 1} more joints leave it, too" if joints > 1 else ""
    return GaitsimError(
        f"{gait.joint_names[joint]} would turn to {sent[keyframe, joint]:.{DECIMALS}f}° at "
        f"{times[keyframe]} ms, beyond the servo's range{others}",
        allowed=f"{servos.low:g}° to {servos.high:g}°",
        remedy="give the range of your servos with --min and --max, or hold them to it with --clip",
    )
