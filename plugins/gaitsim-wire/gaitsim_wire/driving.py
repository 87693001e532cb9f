"""Driving a robot: 50 times a second, measure, check, compute the next angles, and command them."""

import gc
import io
import math
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.runs import write_bytes
from gaitsim_hardware.calibration import Calibration
from gaitsim_hardware.keyframes import Keyframes
from gaitsim_robot.drives import targets
from gaitsim_robot.feeling import Pilot, Truth
from gaitsim_robot.steering import Wheel
from gaitsim_wire.buses import Bus, Reading

Floats = NDArray[np.float64]

RATE = 50.0  # Hz
LATE = 0.5  # frames; a frame that begins later counts as late
RAMP_SPEED = 45.0  # °/s, mean speed of the servo that turns most while the robot rises
RAMP_TIME = 2.0  # s, shortest duration of rising and of lying down
NEAR = 0.5  # °; a single joint that is so close to its pose needs no time to reach it
SILENCE = 0.2  # s without an answer of a servo, after which the robot stops
TIPPED = 1.0  # rad
EXCITED = 6.0  # s, duration of each part of an excitation
EXCITING: tuple[dict[str, int], ...] = (
    {"faster": 2}, {"left": 2}, {"right": 2}, {"step left": 2}, {"step right": 2}, {"slower": 2},
    {"faster": 2, "higher": 3}, {"left": 3, "lower": 3}, {"faster": 2, "left": 2},
    {"step left": 2, "right": 2}, {},
)  # fmt: skip
"""Presses of keys that begin each part: a body that turns and sways shows the errors of horns."""
LEAST_VOLTS = {"feetech": 6.0, "dynamixel": 6.5, "serial": 4.5}


class Stopped(Exception):
    """The robot was stopped at once; the message is the reason, a clause."""


@dataclass(frozen=True)
class SafetyLimits:
    """Limits of measurements beyond which the robot is stopped at once.

    Attributes:
        temperature: highest temperature of a servo, °C.
        volts: lowest voltage, V.
    """

    temperature: float = 65.0
    volts: float = 6.0

    def exceeded(self, reading: Reading, names: tuple[str, ...]) -> str:
        """Return which limit a reading exceeds, a clause; '' for none."""
        hot = np.nan_to_num(reading.temperature)
        if hot.max() > self.temperature:
            return f"the servo of {names[int(hot.argmax())]} has {hot.max():.0f} °C"
        if reading.volts < self.volts:
            return f"the voltage has dropped to {reading.volts:.1f} V"
        if np.abs(reading.orientation[:2]).max() > TIPPED:
            return "the robot has tipped over"
        return "the watchdog of the board has switched the servos off" if reading.tripped else ""


class Player(ABC):
    """A source of joint angles."""

    @property
    @abstractmethod
    def first(self) -> Floats:
        """Joint angles at the start, (joints,) rad; NaN for joints that stay where they are."""

    @abstractmethod
    def step(self, reading: Reading) -> Floats | None:
        """Return the next joint angles, (joints,) rad; None after the last ones."""

    @abstractmethod
    def stop(self) -> None:
        """End the motion smoothly."""

    @abstractmethod
    def give(self, command: str) -> None:
        """Follow a command of the driver, if the player follows commands."""

    def facts(self) -> dict[str, str]:
        """Return the command in force, and a warning without a name if it is too much."""
        return {}


class GaitPlayer(Player):
    """A gait with its reflexes, which follows commands and stands at the start.

    Args:
        pilot: controller of the robot, with ideal sensors.
        imu: whether the robot has an IMU.
        walk: whether to walk at the gait's own speed from the start.
        script: commands that are given by themselves, by frame; after the last one, the robot
            stands. () for none.
    """

    def __init__(
        self, pilot: Pilot, *, imu: bool, walk: bool, script: Sequence[tuple[int, str]] = ()
    ) -> None:
        self._pilot, self._imu, self._script = pilot, imu, deque(script)
        self._wheel, self._frame, self._ending = Wheel(pilot.rhythm.limits[0]), 0, False
        self._angles = pilot.rhythm.standing.copy()
        self._yaw = np.zeros(2)  # first and last
        if walk:
            own = float(pilot.rhythm.own_speed[0])
            self._wheel.drive.append({"at": 0.0, "speed": min(own, self._wheel.limits["speed"])})

    @property
    def first(self) -> Floats:
        """Joint angles at the start, (joints,) rad."""
        return np.asarray(self._pilot.rhythm.standing)

    def step(self, reading: Reading) -> Floats | None:
        """Return the next joint angles, (joints,) rad."""
        legs = len(self._pilot.rhythm.names)
        while self._script and self._script[0][0] <= self._frame:
            self.give(self._script.popleft()[1])
            self._ending = self._ending or not self._script
        target = targets([{**one, "at": 0.0} for one in self._wheel.drive], 1, RATE)
        if self._ending:
            target[:] = 0.0
            if not self._pilot.command[:, :3].any() and self._frame > 0:
                return None
        self._frame += 1
        joints = np.where(np.isfinite(reading.angles), reading.angles, self._angles)
        turned, rates = np.zeros(3), np.zeros(3)
        if self._imu:
            turned, rates = reading.orientation.copy(), reading.rates
            if np.isfinite(turned[2]):
                first, last = (turned[2], turned[2]) if self._frame == 1 else self._yaw
                yaw = last + (turned[2] - last + math.pi) % (2 * math.pi) - math.pi
                self._yaw = np.array([first, yaw])
                turned[2] = yaw - first
        truth = Truth(turned[None], rates[None], np.zeros((1, legs)), joints[None])
        self._angles = self._pilot.step(self._frame, target, truth)[0].copy()
        return self._angles

    def stop(self) -> None:
        """Stand within a stride."""
        self._ending = True

    def give(self, command: str) -> None:
        """Follow a command of the driver."""
        self._wheel.give(command, self._frame / RATE)

    def facts(self) -> dict[str, str]:
        """Return the command in force, and a warning without a name if it is too much."""
        notice = self._wheel.notice()
        return dict(self._wheel.facts()) | ({"": notice} if notice else {})


def excitation() -> list[tuple[int, str]]:
    """Return commands of a minute, by frame, that show the errors of a robot."""
    names = [
        (number, name)
        for number, part in enumerate(EXCITING)
        for name, count in {"stop": 1, **part}.items()
        for _ in range(count)
    ]
    return [(round(number * EXCITED * RATE), name) for number, name in names]


class Tape(Player):
    """Servo angles that were computed before, played in a loop if they repeat.

    Args:
        keyframes: angles, 20 ms apart.
        calibration: calibration of the joints.
    """

    def __init__(self, keyframes: Keyframes, calibration: Calibration) -> None:
        self._angles = calibration.joint_angles(keyframes.degrees)
        self._loop, self._at = keyframes.loop_from, 0

    @property
    def first(self) -> Floats:
        """Joint angles at the start, (joints,) rad."""
        return np.asarray(self._angles[0])

    def step(self, reading: Reading) -> Floats | None:
        """Return the next joint angles, (joints,) rad; None after the last ones."""
        if self._at == len(self._angles):
            if self._loop is None:
                return None
            self._at = self._loop
        self._at += 1
        return np.asarray(self._angles[self._at - 1])

    def stop(self) -> None:
        """End here; the robot lies down from any pose."""
        self._at, self._loop = len(self._angles), None

    def give(self, command: str) -> None:
        """Ignore commands."""


COLUMNS = (
    *("seconds", "commanded", "measured", "load", "temperature", "volts"),
    *("orientation", "rates", "round_trip", "driving"),
)


class Recording:
    """Telemetry of a drive, frame by frame."""

    def __init__(self) -> None:
        self._rows: list[tuple[Any, ...]] = []

    def add(self, *values: Any) -> None:
        """Add a frame, with a value for each of `COLUMNS`."""
        self._rows.append(values)

    def write(self, path: Path, names: tuple[str, ...]) -> None:
        """Write a gait file of the measured angles, with all columns as further arrays.

        Servos that do not report their angles have the commanded ones. The gait begins when the
        robot stands, as in simulation, and ends before it lies down, if it has stood at all.
        """
        columns = zip(*self._rows, strict=True)
        found: dict[str, Any] = {
            name: np.array(one) for name, one in zip(COLUMNS, columns, strict=True)
        }
        measured, commanded = found["measured"], found["commanded"]
        angles = np.where(np.isfinite(measured), measured, commanded)
        if found["driving"].sum() > 1:
            angles = angles[found["driving"]]
        file = io.BytesIO()
        np.savez_compressed(
            file, joint_angles=angles, frame_rate=RATE, joint_names=np.array(names), **found
        )
        write_bytes(path, file.getvalue())

    def felt(self) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the orientation, (frames, 3) rad, and whether the gait was played, (frames,)."""
        orientation, driving = (
            np.array([row[COLUMNS.index(name)] for row in self._rows])
            for name in ("orientation", "driving")
        )
        return orientation, driving

    def __len__(self) -> int:
        return len(self._rows)


@dataclass(eq=False)
class Status:
    """The state of a drive, for display.

    Attributes:
        phase: 'rising', 'driving' or 'lying down'.
        reading: last measurements.
        seconds: time since the torque was switched on, s.
        frames: number of frames.
        late: number of late frames.
        round_trip: mean duration of reading, s.
        clipped: number of frames in which a servo was held at its limits.
    """

    phase: str
    reading: Reading
    seconds: float = 0.0
    frames: int = 0
    late: int = 0
    round_trip: float = 0.0
    clipped: int = 0


class Session:
    """A robot that is driven from switching its torque on to switching it off.

    Args:
        bus: checked wire of the robot.
        player: source of the joint angles.
        calibration: calibration of the joints.
        limits: limits of measurements.
        clock: function that returns the time, s.
        sleep: function that waits for some seconds.

    Attributes:
        recording: telemetry.
        status: state of the drive.
    """

    def __init__(
        self,
        bus: Bus,
        player: Player,
        calibration: Calibration,
        limits: SafetyLimits,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._bus, self._player, self._calibration = bus, player, calibration
        self._limits, self._clock, self._sleep = limits, clock, sleep
        self._names = tuple(calibration.joints)
        self.recording = Recording()
        self.status = Status("rising", Reading.empty(len(self._names)))

    def run(self, poll: Callable[[Status], None]) -> None:
        """Rise, play, and lie down; the torque is off when this returns or raises an error.

        Args:
            poll: function called in each frame; it may call `Player.give` and `Player.stop`, and
                stops the robot at once by any exception.

        Raises:
            Stopped: the robot was stopped at once.
        """
        collected = gc.isenabled()
        gc.disable()  # a collection may take longer than a frame
        try:
            resting = self._resting()
            self._bus.on(self._limited(resting, resting))
            self._play(resting, poll)
        except OSError as error:
            raise Stopped(f"the port was lost ({error})") from None
        finally:
            with suppress(OSError):
                self._bus.off()
            if collected:
                gc.enable()

    def _resting(self) -> Floats:
        """Return the servo angles at which the robot lies, (joints,) °."""
        if not self._bus.senses_joints:
            return self._calibration.servo_angles(self._player.first)
        found = np.full(len(self._names), math.nan)
        for _ in range(10):
            angles = self._bus.read().angles
            found = np.where(np.isfinite(angles), angles, found)
        if not np.isfinite(found).all():
            raise GaitsimError("a servo does not report its angle", where="--port")
        return self._calibration.servo_angles(found)

    def _play(self, resting: Floats, poll: Callable[[Status], None]) -> None:
        now = start = due = self._clock()
        heard = np.full(len(self._names), now)
        last, status = resting, self.status
        for degrees in self._goals(resting):
            safe = self._limited(degrees, last)
            status.clipped += bool(np.abs(safe - degrees).max() > 0.01)
            self._bus.write(safe)
            last = safe
            status.frames += 1
            due += 1 / RATE
            now = self._clock()
            if now < due:
                self._sleep(due - now)
            elif now > due + LATE / RATE:
                status.late += 1
                due = now  # later frames do not catch up
            began = self._clock()
            reading = status.reading = self._bus.read()
            now = self._clock()
            heard[reading.answered] = now
            status.seconds = now - start
            status.round_trip += ((now - began) - status.round_trip) / status.frames
            self.recording.add(
                now - start, self._calibration.joint_angles(safe), reading.angles, reading.load,
                reading.temperature, reading.volts, reading.orientation, reading.rates, now - began,
                status.phase == "driving",
            )  # fmt: skip
            self._check(reading, heard, now)
            poll(status)

    def _check(self, reading: Reading, heard: Floats, now: float) -> None:
        """Stop at once, if a second reading confirms that a limit is exceeded."""
        silent = now - heard > SILENCE
        if silent.all():
            raise Stopped(f"nothing has answered for {SILENCE:g} s")
        if silent.any():
            name = self._names[int(silent.argmax())]
            raise Stopped(f"the servo of {name} has not answered for {SILENCE:g} s")
        if self._limits.exceeded(reading, self._names) and (
            reason := self._limits.exceeded(self._bus.read(), self._names)
        ):
            raise Stopped(reason)

    def _goals(self, resting: Floats) -> Iterator[Floats]:
        """Yield the servo angles of each frame, (joints,) °: rise, play, lie down."""
        first = self._calibration.servo_angles(self._player.first)
        stays = not np.isfinite(first).all()
        first = np.where(np.isfinite(first), first, resting)
        if not stays:
            yield from ramp(resting, first)
        self.status.phase, last = "driving", first
        while (angles := self._player.step(self.status.reading)) is not None:
            last = self._calibration.servo_angles(angles)
            yield last
        self.status.phase = "lying down"
        if not stays or np.abs(last - resting).max() > NEAR:
            yield from ramp(last, resting)

    def _limited(self, degrees: Floats, last: Floats) -> Floats:
        """Return servo angles within the limits of the calibration, and of the servos' speed.

        A servo that lay beyond its limits returns to them at its speed. Angles that are not finite
        are replaced by the last ones.
        """
        most = self._calibration.max_speeds / RATE
        found = np.where(np.isfinite(degrees), degrees, last)
        found = np.clip(found, self._calibration.low, self._calibration.high)
        return np.asarray(np.clip(found, last - most, last + most))


def ramp(start: Floats, end: Floats) -> Iterator[Floats]:
    """Yield servo angles of each frame from one pose to another, with a smooth start and end."""
    seconds = max(RAMP_TIME, float(np.abs(end - start).max()) / RAMP_SPEED)
    frames = math.ceil(seconds * RATE)
    for frame in range(1, frames + 1):
        share = frame / frames
        yield start + share * share * (3 - 2 * share) * (end - start)
