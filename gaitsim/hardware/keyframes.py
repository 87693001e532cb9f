"""Keyframes for servos, within the limits of the servos."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.files.writer import Gait
from gaitsim.hardware.calibration import Calibration
from gaitsim.hardware.loop import Loop

Floats = NDArray[np.float64]

DECIMALS = 2  # of angles in °; the steps of a hobby servo are ten times as wide
ALMOST = 1e-6  # relative tolerance of speeds for rounding errors
SLOWEST = 0.01  # lowest speed of playback; its inverse is the highest


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Servo angles over time.

    Attributes:
        seconds: time of each keyframe in playback, (keyframes,) s, from 0.
        degrees: angle of each servo, (keyframes, joints) °.
        standing: angle of each servo in the standing pose, (joints,) °.
        joint_names: name of each joint.
        clipped: number of angles that were clipped to the limits.
        off: largest deviation from the gait of the straight lines between keyframes, °.
        loop_from: keyframe that follows the last one; None for a gait that is played once.
    """

    seconds: Floats
    degrees: Floats
    standing: Floats
    joint_names: tuple[str, ...]
    clipped: int
    off: float
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
    def fastest(self) -> Floats:
        """Largest speed of each servo, (joints,) °/s."""
        return np.asarray(np.abs(self._steps).max(axis=0) / self.interval)

    @property
    def _steps(self) -> Floats:
        again = [] if self.loop_from is None else [self.degrees[self.loop_from]]
        return np.diff(np.array([*self.degrees, *again]), axis=0)


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
        gait: the joint angles.
        calibration: calibration of the joints, in the same order.
        keyframe_ms: time between keyframes in playback; None for one keyframe per frame. A loop
            uses the nearest time that divides its period.
        speed: speed of playback; 1 is that of the simulation.
        clip: whether to clip angles beyond the limits instead of raising an error.
        loop: part of the gait that repeats; None plays the whole gait once.

    Raises:
        GaitsimError: an angle or a speed is beyond a limit, or there are fewer than two keyframes.
    """
    check_playback(speed)
    frames = np.arange(len(gait.angles)) / gait.frame_rate
    turned = calibration.servo_angles(gait.angles)
    wished = 1 / gait.frame_rate if keyframe_ms is None else keyframe_ms / 1000 * speed
    if loop is None:
        times = frames if keyframe_ms is None else np.arange(0, frames[-1] + 5e-10, wished)
        degrees, loop_from = interpolated(times, frames, turned), None
    else:
        times, degrees, loop_from = _cycle(loop, frames, turned, wished)
    if len(times) < 2 or times[1] / speed < 0.001 - 1e-9:
        raise GaitsimError(
            f"a gait of {frames[-1] / speed * 1000:g} ms gives "
            + ("only one keyframe" if len(times) < 2 else "keyframes less than 1 ms apart"),
            where="" if keyframe_ms is None else f"--keyframe-ms {keyframe_ms}",
            allowed="two keyframes or more, at least 1 ms apart",
        )
    # Round before the check: a hundredth of a degree beyond a limit does no harm.
    sent = np.round(degrees, DECIMALS) + 0.0  # no −0.0
    standing = calibration.servo_angles(gait.standing)
    excess = calibration.excess(sent)
    beyond = excess > 0
    if beyond.any() and not clip:
        frame, joint = map(int, np.unravel_index(np.argmax(excess), excess.shape))
        joints = int(beyond.any(axis=0).sum())
        raise beyond_range(
            calibration,
            joint,
            sent[frame, joint],
            f"at {times[frame] / speed * 1000:.0f} ms (frame {times[frame] * gait.frame_rate:.0f})",
            f"; {joints - 1} more joint{'s' * (joints > 2)} would, too" if joints > 1 else "",
        )
    held = np.clip(sent, calibration.low, calibration.high)
    last = times[-1] if loop is None else loop.start
    inside = frames <= last
    off = np.abs(interpolated(frames, times, held) - turned)[inside].max() if inside.any() else 0.0
    found = Keyframes(
        times / speed,
        held,
        np.clip(standing, calibration.low, calibration.high) if clip else standing,
        gait.joint_names,
        int(beyond.sum()),
        float(off),
        loop_from,
    )
    _check_speed(found, calibration, speed, gait.frame_rate)
    return found


def check_playback(speed: float) -> None:
    """Check the speed of playback.

    Raises:
        GaitsimError: the speed is out of range.
    """
    if not SLOWEST <= speed <= 1 / SLOWEST:
        raise GaitsimError(
            f"invalid speed of playback {speed:g}",
            where="--speed",
            allowed=f"{SLOWEST:g} to {1 / SLOWEST:g}; 1 is the simulated speed, 0.5 is half of it",
        )


def interpolated(times: NDArray[Any], known: NDArray[Any], angles: Floats) -> Floats:
    """Interpolate linearly from the angles at times `known` to `times`, (times, joints)."""
    return np.stack([np.interp(times, known, column) for column in angles.T], axis=1)


def beyond_range(
    calibration: Calibration, joint: int, degrees: float, when: str, others: str = ""
) -> GaitsimError:
    """Return the error for an angle beyond a servo's range."""
    return GaitsimError(
        f"{[*calibration.joints][joint]} would turn to {degrees:.{DECIMALS}f}° {when}, beyond the "
        f"servo's range{others}",
        where=calibration.source,
        allowed=f"{calibration.low[joint]:g}° to {calibration.high[joint]:g}°",
        remedy=f"set the range of your servos {calibration.limited_by}, or clip the angles with "
        "--clip",
    )


def _cycle(loop: Loop, frames: Floats, turned: Floats, wished: float) -> tuple[Floats, Floats, int]:
    """Return times and angles up to the end of a loop, and the keyframe at its start."""
    count = max(round(loop.period / wished), 2)
    interval = loop.period / count
    first = int(np.ceil(loop.start / interval - 1e-9))
    if (first + count) * interval > frames[-1] + 1e-9:  # the gait ends before the loop does
        first = max(int((frames[-1] + 1e-9) / interval) - count, 0)
    times = np.arange(first + count + 1, dtype=np.float64) * interval
    degrees = interpolated(times, frames, turned)
    # Spread the difference between two cycles over the whole cycle, to avoid a jump.
    jump = degrees[first] - degrees[-1]
    degrees[first:] += np.linspace(0, 1, count + 1)[:, None] * jump
    return times[:-1], degrees[:-1], first


def _check_speed(
    found: Keyframes, calibration: Calibration, speed: float, frame_rate: float
) -> None:
    """Raise an error if a servo cannot follow the gait."""
    share = found.fastest / calibration.fastest
    if share.max() <= 1 + ALMOST:
        return
    joint = int(share.argmax())
    keyframe = int(np.abs(found._steps[:, joint]).argmax())
    seconds = found.seconds[keyframe]
    servo = [*calibration.joints.values()][joint].servo
    named = f"the servo {servo} can" if servo else "the calibration allows"
    slower = np.floor(speed / share.max() * 100) / 100
    raise GaitsimError(
        f"{found.joint_names[joint]} would turn at {found.fastest[joint]:.0f}°/s at "
        f"{seconds * 1000:.0f} ms (frame {seconds * speed * frame_rate:.0f}), faster than {named}",
        where=calibration.source,
        allowed=f"up to {calibration.fastest[joint]:.0f}°/s",
        remedy=f"play it slower, with --speed {max(slower, SLOWEST):g}, and check the result; or "
        "evolve it with slower servos",
    )
