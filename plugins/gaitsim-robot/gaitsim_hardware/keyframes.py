"""Keyframes for servos, within their limits: loops in a gait, and tables of keyframes."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.gait import Gait, check_folder
from gaitsim.plugin.runs import write_bytes
from gaitsim_hardware.calibration import Calibration

Floats = NDArray[np.float64]

DECIMALS = 2  # of angles in °; the steps of a hobby servo are ten times as wide
SPEED_TOLERANCE = 1e-6  # relative, for rounding errors
MIN_SPEED = 0.01  # lowest speed of playback; its inverse is the highest


@dataclass(frozen=True)
class Loop:
    """A part of a gait that repeats.

    Attributes:
        start: start of the first cycle, after the initial transient, s.
        period: duration of a cycle, s.
        error: largest difference between a cycle and the next, rad.
    """

    start: float
    period: float
    error: float


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Servo angles over time.

    Attributes:
        seconds: time of each keyframe in playback, (keyframes,) s, from 0.
        degrees: angle of each servo, (keyframes, joints) °.
        standing: angle of each servo in the standing pose, (joints,) °.
        joint_names: name of each joint.
        clipped: number of angles that were clipped to the limits.
        deviation: largest deviation of the linearly interpolated keyframes from the gait, °.
        loop_from: index of the keyframe that follows the last one; None for a gait that is played
            once.
    """

    seconds: Floats
    degrees: Floats
    standing: Floats
    joint_names: tuple[str, ...]
    clipped: int
    deviation: float
    loop_from: int | None = None

    @property
    def milliseconds(self) -> NDArray[np.int64]:
        """Time of each keyframe to the nearest millisecond, (keyframes,)."""
        return np.rint(self.seconds * 1000).astype(np.int64)

    @property
    def interval(self) -> float:
        """Time between keyframes, s."""
        return float(self.seconds[1] - self.seconds[0])

    @property
    def peak_speeds(self) -> Floats:
        """Largest speed of each servo in the gait, (joints,) °/s."""
        return np.asarray(np.abs(self._steps).max(axis=0) / self.interval)

    @property
    def _steps(self) -> Floats:
        following = [] if self.loop_from is None else [self.degrees[self.loop_from]]
        return np.diff(np.array([*self.degrees, *following]), axis=0)


def keyframes_of(
    gait: Gait,
    calibration: Calibration,
    keyframe_ms: int | None = None,
    *,
    speed: float = 1.0,
    clip: bool = False,
    loop: Loop | None = None,
) -> Keyframes:
    """Return the keyframes of a gait, within the limits of its servos.

    Args:
        gait: joint angles of the gait.
        calibration: calibration of the joints, in the same order.
        keyframe_ms: time between keyframes in playback, ms; None for one keyframe per frame. A
            loop uses the nearest time that divides its period.
        speed: speed of playback; 1 is the speed of the simulation.
        clip: whether to clip angles beyond the limits instead of raising an error.
        loop: part of the gait that repeats; None plays the whole gait once.
    """
    check_playback(speed)
    if gait.slides:
        raise GaitsimError(
            f"the joint {gait.slides[0]!r} slides, and servos turn",
            allowed="--format csv, npz, mat, motion or ros2 for robots with slides",
        )
    frames = np.arange(len(gait.angles)) / gait.frame_rate
    turned = calibration.servo_angles(gait.angles)
    interval = 1 / gait.frame_rate if keyframe_ms is None else keyframe_ms / 1000 * speed
    if loop is None:
        times = frames if keyframe_ms is None else np.arange(0, frames[-1] + 5e-10, interval)
        degrees, loop_from = interpolate(times, frames, turned), None
    else:
        times, degrees, loop_from = _loop_keyframes(loop, frames, turned, interval)
    if len(times) < 2 or times[1] / speed < 0.001 - 1e-9:
        raise GaitsimError(
            f"a gait of {frames[-1] / speed * 1000:g} ms gives "
            + ("only one keyframe" if len(times) < 2 else "keyframes less than 1 ms apart"),
            where="" if keyframe_ms is None else f"--keyframe-ms {keyframe_ms}",
            allowed="at least two keyframes, at least 1 ms apart",
        )
    # Rounding comes before the check: a hundredth of a degree beyond a limit does no harm.
    sent = np.round(degrees, DECIMALS) + 0.0  # no −0.0
    standing = calibration.servo_angles(gait.standing)
    excess = calibration.excess(sent)
    beyond = excess > 0
    if beyond.any() and not clip:
        frame, joint = map(int, np.unravel_index(np.argmax(excess), excess.shape))
        joints = int(beyond.any(axis=0).sum())
        raise range_error(
            calibration,
            joint,
            sent[frame, joint],
            f"at {times[frame] / speed * 1000:.0f} ms (frame {times[frame] * gait.frame_rate:.0f})",
            f"; so would {joints - 1} more joint{'s' * (joints > 2)}" if joints > 1 else "",
        )
    clipped = np.clip(sent, calibration.low, calibration.high)
    compared = frames <= (times[-1] if loop is None else loop.start)
    deviations = np.abs(interpolate(frames, times, clipped) - turned)[compared]
    found = Keyframes(
        times / speed,
        clipped,
        np.clip(standing, calibration.low, calibration.high) if clip else standing,
        gait.joint_names,
        int(beyond.sum()),
        float(deviations.max(initial=0.0)),
        loop_from,
    )
    _check_speed(found, calibration, speed, gait.frame_rate)
    return found


def check_playback(speed: float) -> None:
    """Check the speed of playback."""
    if not MIN_SPEED <= speed <= 1 / MIN_SPEED:
        raise GaitsimError(
            f"invalid playback speed: {speed:g}",
            where="--speed",
            allowed=f"{MIN_SPEED:g} to {1 / MIN_SPEED:g}; 1 is the simulated speed, 0.5 half of it",
        )


def interpolate(times: NDArray[Any], known: NDArray[Any], angles: Floats) -> Floats:
    """Return the angles at `times`, (times, joints), interpolated linearly.

    Args:
        times: times of the result, (times,).
        known: times of `angles`, (frames,), increasing.
        angles: known angles, (frames, joints).
    """
    return np.stack([np.interp(times, known, column) for column in angles.T], axis=1)


def range_error(
    calibration: Calibration, joint: int, degrees: float, when: str, others: str = ""
) -> GaitsimError:
    """Return the error for an angle beyond a servo's range."""
    return GaitsimError(
        f"{[*calibration.joints][joint]} would turn to {degrees:.{DECIMALS}f}° {when}, beyond its "
        f"servo's range{others}",
        where=calibration.source,
        allowed=f"{calibration.low[joint]:g}° to {calibration.high[joint]:g}°",
        remedy=f"set the range of your servos {calibration.limited_by}, or clip the angles with "
        "--clip",
    )


def _loop_keyframes(
    loop: Loop, frames: Floats, turned: Floats, interval: float
) -> tuple[Floats, Floats, int]:
    """Return times and angles up to the end of a loop, and the index of the loop's first keyframe.

    The difference between two successive cycles is spread over the loop, so that the robot does
    not jerk when the loop starts again.
    """
    count = max(round(loop.period / interval), 2)
    interval = loop.period / count
    first = int(np.ceil(loop.start / interval - 1e-9))
    if (first + count) * interval > frames[-1] + 1e-9:  # the gait ends before the loop does
        first = max(int((frames[-1] + 1e-9) / interval) - count, 0)
    times = np.arange(first + count + 1, dtype=np.float64) * interval
    degrees = interpolate(times, frames, turned)
    jump = degrees[first] - degrees[-1]
    degrees[first:] += np.linspace(0, 1, count + 1)[:, None] * jump
    return times[:-1], degrees[:-1], first


def _check_speed(
    found: Keyframes, calibration: Calibration, speed: float, frame_rate: float
) -> None:
    """Raise an error if a servo cannot follow the gait."""
    share = found.peak_speeds / calibration.max_speeds
    if share.max() <= 1 + SPEED_TOLERANCE:
        return
    joint = int(share.argmax())
    keyframe = int(np.abs(found._steps[:, joint]).argmax())
    seconds = found.seconds[keyframe]
    servo = [*calibration.joints.values()][joint].servo
    named = f"the servo {servo} can" if servo else "the calibration allows"
    slower = np.floor(speed / share.max() * 100) / 100
    raise GaitsimError(
        f"{found.joint_names[joint]} would turn at {found.peak_speeds[joint]:.0f}°/s at "
        f"{seconds * 1000:.0f} ms (frame {seconds * speed * frame_rate:.0f}), faster than {named}",
        where=calibration.source,
        allowed=f"up to {calibration.max_speeds[joint]:.0f}°/s",
        remedy=f"export with --speed {max(slower, MIN_SPEED):g} and check the result, or evolve "
        "the gait with slower servos",
    )


TOLERANCE = np.radians(1.0)  # rad, largest difference between a cycle and the next
MAX_PERIOD = 0.5  # share of the gait, as every cycle must occur twice
MIN_COMPARED = 0.25  # smallest share of the gait that is compared with the next cycle
MIN_MOTION = np.radians(1.0)  # rad; if all joints turn less, the robot stands still
# rad; the initial transient ends with the last difference above this and above twice the smallest
# error of the loop
TRANSIENT = np.radians(0.1)


def find_loop(angles: Floats, frame_rate: float) -> Loop | None:
    """Return the shortest part of a gait that repeats to within 1°; None if no part does.

    The joint angles must repeat, not only the contacts of the feet. A period need not be a whole
    number of frames, as a cubic spline interpolates the angles.

    Args:
        angles: joint angles, (frames, joints) rad.
        frame_rate: frames per second, Hz.
    """
    from scipy.interpolate import CubicSpline
    from scipy.optimize import minimize_scalar

    frames = len(angles)
    if frames < 8 or np.ptp(angles[frames // 2 :], axis=0).max() < MIN_MOTION:
        return None
    by_lag = _differences(angles)
    spline = CubicSpline(np.arange(frames), angles)

    def differences(lag: float, first: int) -> Floats:
        times = np.arange(first, int(frames - 1 - lag + 1e-9) + 1)
        return np.asarray(np.abs(spline(times + lag) - angles[first : first + len(times)]).max(1))

    def worst(lag: float) -> float:
        return float(differences(lag, _first_compared(frames, lag)).max())

    inner = by_lag[1:-1]
    minima = 1 + np.flatnonzero((inner <= by_lag[:-2]) & (inner < by_lag[2:]))
    for minimum in minima[by_lag[minima] < by_lag.max() / 2]:
        nearest = int(minimum) + 2
        bounds = nearest - 1, min(nearest + 1.0, MAX_PERIOD * (frames - 1))
        found = minimize_scalar(worst, bounds=bounds, options={"xatol": 1e-4})
        lag = float(found.x)
        error = worst(lag)
        if error <= TOLERANCE:
            errors = differences(lag, 0)
            start = int(np.flatnonzero(errors > max(2 * error, TRANSIENT)).max(initial=-1)) + 1
            return Loop(start / frame_rate, lag / frame_rate, float(errors[start:].max()))
    return None


def _first_compared(frames: int, lag: float) -> int:
    """Return the first frame that is compared with the frame one cycle later."""
    return max(int(frames - 1 - lag - max(lag, MIN_COMPARED * frames)), 0)


def _differences(angles: Floats) -> Floats:
    """Return the largest difference between frames that are 2, 3, … frames apart, rad.

    Only the last part of the gait is compared, as its beginning may be a transient.
    """
    frames = len(angles)
    found = []
    for lag in range(2, int(MAX_PERIOD * (frames - 1)) + 1):
        first = _first_compared(frames, lag)
        found.append(np.abs(angles[first + lag :] - angles[first : frames - lag]).max())
    return np.array(found)


def write_table(keyframes: Keyframes, calibration: Calibration, format: str, path: Path) -> None:
    """Write angles (format 'servo') or goal positions of servos as CSV, atomically.

    The columns are `time_ms`, then one for each joint with its unit, or for each servo, named after
    its id. The unit is `[deg]` for angles of joints, `[servo deg]` for those of servos whose centre
    or direction differs.
    """
    check_folder(path)
    unit = "deg" if calibration.same_as_joints else "servo deg"
    names: Sequence[str] = [f"{name} [{unit}]" for name in keyframes.joint_names]
    rows: list[list[object]] = [
        [f"{angle:.{DECIMALS}f}" for angle in row] for row in keyframes.degrees.tolist()
    ]
    if format != "servo":
        names = [str(joint.id) for joint in calibration.joints.values()]
        rows = calibration.ticks(keyframes.degrees).tolist()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_ms", *names])
    for time, row in zip(keyframes.milliseconds.tolist(), rows, strict=True):
        writer.writerow([time, *row])
    write_bytes(path, text.getvalue().encode())
