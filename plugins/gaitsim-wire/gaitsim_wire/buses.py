"""The client's side of a wire: servos are checked, read, commanded and switched off."""

import math
import termios
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError
from gaitsim_hardware.arduino import servo_checksum
from gaitsim_hardware.calibration import Calibration
from gaitsim_robot.rollout import tilt_and_yaw
from gaitsim_wire.emulator import ON, STATE
from gaitsim_wire.packets import (
    ALL,
    PING,
    READ,
    SYNC_READ,
    SYNC_WRITE,
    WRITE,
    Packet,
    Protocol,
    SketchProtocol,
)
from gaitsim_wire.tables import IMU, IMU_LENGTH, ORIENTATION, RATES, TABLES, Register

Floats = NDArray[np.float64]

ANSWER = 0.012  # s, longest wait for replies besides the time of their bytes; USB may need half
TRIES = 5  # attempts before torque is on
WATCHDOG = 10  # × 20 ms, of Dynamixel servos
BEYOND = 5.0  # °, how far a servo may be beyond its limits before the start
OUTSIDE = 15.0  # °, how far a joint may seem to be beyond its ends in the model
WARM_UP = 5.0  # s, longest wait for the calibration of a sketch's sensor


@dataclass(eq=False)
class Reading:
    """Measurements in one frame; NaN for what was not measured.

    Attributes:
        angles: joint angles, (joints,) rad.
        load: torque as a share of the stall torque, (joints,).
        temperature: temperature of each servo, (joints,) °C.
        volts: lowest voltage, V.
        orientation: roll to the right, pitch nose down and yaw to the left, (3,) rad; yaw from −π.
        rates: angular velocity about the trunk's axes, (3,) rad/s.
        answered: whether each servo has answered, (joints,); a sketch answers for all.
        tripped: whether a watchdog has switched the servos off.
    """

    angles: Floats
    load: Floats
    temperature: Floats
    volts: float
    orientation: Floats
    rates: Floats
    answered: NDArray[np.bool_]
    tripped: bool = False

    @classmethod
    def empty(cls, joints: int) -> "Reading":
        """Return a reading without measurements."""
        angles, load, temperature = np.full((3, joints), math.nan)
        turned, rates = np.full((2, 3), math.nan)
        answered = np.zeros(joints, dtype=np.bool_)
        return cls(angles, load, temperature, math.nan, turned, rates, answered)


class Bus(ABC):
    """A wire with the servos of a robot.

    Args:
        port: open port with `write`, `read`, `in_waiting` and `reset_input_buffer`.
        baud: baud rate of the port.
        calibration: servos of the joints.
        clock: function that returns the time, s.
        sleep: function that waits for some seconds.
    """

    protocol: Protocol
    senses_joints = True

    def __init__(
        self,
        port: Any,
        baud: int,
        calibration: Calibration,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.port, self._byte = port, 10 / baud
        self._calibration, self._clock, self._sleep = calibration, clock, sleep
        self._joints = len(calibration.joints)

    @abstractmethod
    def check(self) -> None:
        """Check that the robot on the wire is the one of the calibration, with its torque off.

        Raises:
            GaitsimError: a servo is missing, of another model, in another mode or out of limits.
        """

    @abstractmethod
    def read(self) -> Reading:
        """Measure."""

    @abstractmethod
    def write(self, degrees: Floats) -> None:
        """Command servo angles, (joints,) °, which are within their limits."""

    @abstractmethod
    def on(self, degrees: Floats) -> None:
        """Switch the servos on at these angles, (joints,) °."""

    @abstractmethod
    def off_frame(self) -> bytes:
        """Return the bytes that switch all servos off."""

    def off(self) -> None:
        """Switch all servos off; repeated, as nothing confirms it."""
        for _ in range(3):
            self.port.write(self.off_frame())

    def _ask(self, packet: Packet, count: int, size: int) -> Iterator[Packet]:
        """Send a packet; yield the replies until there are `count`, or the time is over.

        Args:
            packet: packet to send.
            count: number of replies.
            size: bytes of data in each reply.
        """
        try:
            self.port.reset_input_buffer()
        except termios.error as error:  # of a port that was unplugged; it is not an OSError
            raise OSError(*error.args) from None
        frame = self.protocol.encode(packet)
        self.port.write(frame)
        self._wrong = 0
        bytes_ = len(frame) + count * (self.protocol.overhead + size)
        end, received, found = self._clock() + ANSWER + bytes_ * self._byte, bytearray(), 0
        while found < count:
            late = self._clock() >= end
            if waiting := self.port.in_waiting:
                received += self.port.read(waiting)
                self._wrong += waiting
            elif not late:
                self._sleep(0.0002)
                continue
            for reply in self.protocol.take(received, reply=True, final=late):
                found += 1
                self._wrong = 0
                yield reply
            if late:
                return

    def _name(self, joint: int) -> str:
        return [*self._calibration.joints][joint]


class ServoBus(Bus):
    """Servos on a bus.

    Args:
        kind: 'feetech' or 'dynamixel'.
        imu: whether an IMU answers.
        others: as in `Bus`.
    """

    def __init__(self, kind: str, port: Any, baud: int, *others: Any, imu: bool = False) -> None:
        super().__init__(port, baud, *others)
        self._kind, self._table, self._imu = kind, TABLES[kind], imu
        self.protocol = self._table.protocol
        self._ids = [int(joint.id or 0) for joint in self._calibration.joints.values()]
        self._place = {number: joint for joint, number in enumerate(self._ids)}

    def check(self) -> None:
        """Check models, modes and positions of all servos, and that no id has two."""
        table = self._table
        _, length = table.watched
        used = (self._joints * (self.protocol.overhead + length) + 500) * self._byte
        if used > 0.016:
            raise GaitsimError(
                f"at this baud rate, reading {self._joints} servos takes {1000 * used:.0f} ms of "
                "each 20 ms",
                where="--baud",
                allowed="a rate at which it takes less than 16 ms",
                remedy="set the servos to 1000000 baud with their vendor's tool",
            )
        found = [self._get(number, table.model) for number in self._ids]
        self._check_found(found)
        for joint, model in enumerate(found):
            servo = [*self._calibration.joints.values()][joint].servo
            if model != table.models[servo]:
                known = {number: name for name, number in table.models.items()}
                raise self._error(
                    joint,
                    f"is a servo of model {known.get(int(model or 0), model)}, not {servo}",
                    "use the calibration of this robot, or correct its ids",
                )
            mode = self._get(self._ids[joint], table.mode)
            if mode is None:
                raise self._error(joint, "has stopped answering", "check its cable and power")
            if mode != table.position_mode:
                raise self._error(
                    joint,
                    "is not in position mode",
                    f"write {table.position_mode} to the address {table.mode.address} with the "
                    "vendor's tool",
                )
            if table.reverse and (self._get(self._ids[joint], table.reverse) or 0) & 1:
                raise self._error(
                    joint,
                    "is set to turn in reverse, which the calibration does not know",
                    f"write 0 to its address {table.reverse.address}, or use the calibration of "
                    "this robot",
                )
        self._check_places()
        if self._imu and self._block(IMU, RATES, IMU_LENGTH) is None:
            raise GaitsimError(
                f"no IMU answers at the id {IMU}",
                where="--imu",
                allowed="an IMU as that of an OpenCR board",
                remedy="omit --imu, if the gait needs no IMU",
            )

    def scan(self) -> list[int]:
        """Return the ids of all servos of the known models; takes some seconds."""
        answering = [one for one in range(253) if [*self._ask(Packet(one, PING), 1, 0)]]
        known = self._table.models.values()
        return [one for one in answering if self._get(one, self._table.model) in known]

    def missing(self) -> list[int]:
        """Return the ids of the calibration that do not answer."""
        return [one for one in self._ids if self._get(one, self._table.model) is None]

    def _check_found(self, found: Sequence[int | None]) -> None:
        """Report servos that do not answer, or of which two have the same id."""
        missing = [joint for joint, model in enumerate(found) if model is None]
        if not missing:
            return
        garbled = [joint for joint in missing if self._garbles(self._ids[joint])]
        names = ", ".join(f"{self._ids[joint]} ({self._name(joint)})" for joint in missing[:4])
        more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
        if garbled and len(missing) < self._joints:
            joint = garbled[0]
            raise self._error(
                joint,
                "gives garbled answers: two servos probably have this id",
                "connect them one by one, and give each its own id",
            )
        if len(missing) == self._joints:
            other = self._other_baud()
            raise GaitsimError(
                "no servo answers" if other is None else f"the servos answer at {other} baud",
                where="--baud" if other else self._calibration.source,
                remedy=f"add --baud {other}"
                if other
                else f"switch the servos' power on, and check the cable, --bus {self._kind} and "
                "the ids in the calibration, which 'gaitsim robots calibrate' finds",
            )
        what = "servos does" if len(missing) == 1 else "servos do"
        raise GaitsimError(
            f"{len(missing)} of {self._joints} {what} not answer: id {names}{more}",
            where=self._calibration.source,
            remedy="check their cables and power, or their ids in the calibration",
        )

    def _check_places(self) -> None:
        """Report servos that stand beyond the limits of the calibration."""
        positions = [self._get(number, self._table.position) for number in self._ids]
        degrees = self._calibration.angles_of_ticks(np.array(positions, dtype=np.float64))
        excess = self._calibration.excess(degrees)
        joint = int(np.nan_to_num(excess, nan=-1).argmax())
        if excess[joint] > BEYOND:
            low, high = self._calibration.low[joint], self._calibration.high[joint]
            raise self._error(
                joint,
                f"stands at {degrees[joint]:.0f}°, beyond its limits of {low:g}° to {high:g}°",
                "turn the joint by hand into its range; if it is within, the direction or the "
                "offset in the calibration is wrong, or the calibration is that of another robot",
            )

        ends = self._calibration.ends
        if ends is None:
            return
        angles = self._calibration.joint_angles(degrees)
        outside = np.degrees(np.maximum(ends[:, 0] - angles, angles - ends[:, 1]))
        joint = int(np.nan_to_num(outside, nan=-1).argmax())
        if outside[joint] > OUTSIDE:
            low, high = np.degrees(ends[joint])
            raise self._error(
                joint,
                f"says that its joint is at {math.degrees(angles[joint]):.0f}°, but in the model "
                f"it turns from {low:.0f}° to {high:.0f}°",
                "calibrate the joint again with 'gaitsim robots calibrate'; its direction or "
                "offset is wrong, or the calibration is that of another robot",
            )

    def _error(self, joint: int, what: str, remedy: str) -> GaitsimError:
        where = self._calibration.source
        return GaitsimError(
            f"id {self._ids[joint]} ({self._name(joint)}) {what}", where=where, remedy=remedy
        )

    def _garbles(self, number: int) -> bool:
        """Return whether an id always answers with bytes, but never with a valid packet."""
        for _ in range(TRIES):
            if [*self._ask(Packet(number, PING), 1, 0)] or not self._wrong:
                return False
        return True

    def _other_baud(self) -> int | None:
        """Return another baud rate at which the first servo answers; None for none."""
        own = round(10 / self._byte)
        try:
            for baud in self._table.bauds:
                self.port.baudrate = baud
                if baud != own and self._get(self._ids[0], self._table.model) is not None:
                    return baud
        finally:
            self.port.baudrate = own
        return None

    def _number(self, value: int) -> bytes:
        return value.to_bytes(self.protocol.word, "little")

    def _block(self, number: int, first: int, length: int) -> bytes | None:
        """Return bytes of a table; None if the servo does not answer."""
        ask = Packet(number, READ, self._number(first) + self._number(length))
        for _ in range(TRIES):
            for reply in self._ask(ask, 1, length):
                if reply.id == number and len(reply.data) == length:
                    return reply.data
        return None

    def _get(self, number: int, part: Register) -> int | None:
        found = self._block(number, part.address, part.size)
        return None if found is None else part.read(found, part.address)

    def _write_all(self, part: Register, value: int) -> None:
        """Write a value to all servos; repeated, as nothing confirms it."""
        for _ in range(3):
            self.port.write(self.protocol.encode(self._to_all(part, value)))

    def _to_all(self, part: Register, value: int) -> Packet:
        return Packet(ALL, WRITE, self._number(part.address) + part.write(value))

    def read(self) -> Reading:
        """Read all servos, and the IMU."""
        found, table = Reading.empty(self._joints), self._table
        first, length = table.watched
        head = self._number(first) + self._number(length)
        positions, volts = found.angles.copy(), [math.nan]
        ask = Packet(ALL, SYNC_READ, head + bytes(self._ids))
        for reply in self._ask(ask, self._joints, length):
            joint, data = self._place.get(reply.id, -1), reply.data
            if joint < 0 or len(data) != length:
                continue
            found.answered[joint] = True
            positions[joint] = table.position.read(data, first)
            direction = [*self._calibration.joints.values()][joint].direction
            found.load[joint] = direction * table.load.read(data, first) / 1000
            found.temperature[joint] = table.temperature.read(data, first)
            volts.append(table.volts.read(data, first) / 10)
        degrees = self._calibration.angles_of_ticks(positions)
        found.angles = self._calibration.joint_angles(degrees)
        found.volts = float(np.fmin.reduce(volts))
        if self._imu and found.answered.any():
            head = self._number(RATES) + self._number(IMU_LENGTH)
            for reply in self._ask(Packet(IMU, READ, head), 1, IMU_LENGTH):
                if reply.id == IMU and len(reply.data) == IMU_LENGTH:
                    values = np.frombuffer(reply.data, "<f4").astype(np.float64)
                    found.rates = values[:3]
                    found.orientation = tilt_and_yaw(values[(ORIENTATION - RATES) // 4 :])
        return found

    def write(self, degrees: Floats) -> None:
        """Command servo angles, (joints,) °."""
        self._write_each(self._table.goal, self._calibration.ticks(degrees).tolist())

    def _write_each(self, part: Register, values: Sequence[int], times: int = 1) -> None:
        """Write a value to each servo of the calibration; may be repeated, as nothing confirms."""
        data = self._number(part.address) + self._number(part.size)
        for number, value in zip(self._ids, values, strict=True):
            data += bytes([number]) + part.write(value)
        for _ in range(times):
            self.port.write(self.protocol.encode(Packet(ALL, SYNC_WRITE, data)))

    def on(self, degrees: Floats) -> None:
        """Switch the servos on at these angles, (joints,) °.

        A servo that had missed its goal would jump to an old one, so goals are read back before.
        """
        goal, watchdog = self._table.goal, self._table.watchdog
        if watchdog:  # a tripped one refuses goals
            self._write_all(watchdog, 0)
        ticks = dict(zip(self._ids, self._calibration.ticks(degrees).tolist(), strict=True))
        head = self._number(goal.address) + self._number(goal.size)
        for _ in range(10 * TRIES):
            self.write(degrees)
            replies = self._ask(Packet(ALL, SYNC_READ, head + bytes(ticks)), len(ticks), goal.size)
            for reply in replies:
                if ticks.get(reply.id) == goal.read(reply.data, goal.address):
                    del ticks[reply.id]
            if not ticks:
                break
        else:
            raise GaitsimError("a servo does not accept its goal", where="--port")
        # Not to all servos: the calibration may be that of one joint.
        if watchdog:
            self._write_each(watchdog, [WATCHDOG] * self._joints, times=3)
        self._write_each(self._table.torque, [1] * self._joints, times=3)

    def off_frame(self) -> bytes:
        """Return the bytes that switch all servos off."""
        return self.protocol.encode(self._to_all(self._table.torque, 0))


class SketchBus(Bus):
    """A board with the sketch `receiver.ino`, whose hobby servos do not report their angles."""

    protocol = SketchProtocol()
    senses_joints = False
    _sent, _state = 0, 0

    def check(self) -> None:
        """Check that the sketch is that of the calibration, and wait for its sensor."""
        for _ in range(TRIES):
            status = self._exchange(SketchProtocol.HELLO)
            if status is not None:
                break
            self._sleep(0.5)  # many boards restart when their port is opened
        else:
            raise GaitsimError(
                "no sketch answers",
                where="--port",
                remedy="upload the sketch of 'gaitsim export RUN --format arduino --stream', which "
                "uses 115200 baud",
            )
        if status[1:3] != (self._joints, servo_checksum(self._calibration)):
            raise GaitsimError(
                f"the sketch on the board is for other servos: it has {status[1]} joints",
                where=self._calibration.source,
                allowed=f"a sketch made with this calibration, for {self._joints} joints",
                remedy="export the sketch again with --stream and this calibration, and upload it",
            )
        end = self._clock() + WARM_UP
        while status is None or status[-1] == 2:
            if self._clock() > end:
                raise GaitsimError(
                    "the sensor on the board does not finish its calibration",
                    where="--port",
                    remedy="keep the robot still for a second",
                )
            self._sleep(0.05)
            status = self._exchange(SketchProtocol.STATUS)

    def _exchange(self, kind: int, data: bytes = b"") -> tuple[Any, ...] | None:
        """Send a packet; return the status, None without one."""
        self._sent = (self._sent + 1) % 256
        for reply in self._ask(Packet(self._sent, kind, data), 1, STATE.size):
            if reply.id == self._sent and len(reply.data) == STATE.size:
                return STATE.unpack(reply.data)
        return None

    def read(self) -> Reading:
        """Ask for the status."""
        found, status = Reading.empty(self._joints), self._exchange(SketchProtocol.STATUS)
        if status is None:
            return found
        state, _, _, volts, *tilt, sensor = status
        found.answered[:] = True
        found.tripped = self._state == ON and state != ON
        found.volts = volts / 1000 or math.nan
        if sensor == 1:
            found.orientation = np.array(tilt[:3]) / 1e4
            found.rates = np.array(tilt[3:]) / 1e3
        return found

    def write(self, degrees: Floats) -> None:
        """Command servo angles, (joints,) °."""
        self._send(np.rint(10 * self._calibration.pulses(degrees)))

    def _send(self, tenths: Floats) -> None:
        self._sent, self._state = (self._sent + 1) % 256, ON
        packet = Packet(self._sent, SketchProtocol.PULSES, tenths.astype("<u2").tobytes())
        self.port.write(self.protocol.encode(packet))

    def on(self, degrees: Floats) -> None:
        """Switch the servos on one by one, as all of them would draw too much current."""
        tenths = np.rint(10 * self._calibration.pulses(degrees))
        for joint in range(self._joints):
            for _ in range(3):
                self._send(np.where(np.arange(self._joints) <= joint, tenths, 0))
                self._sleep(0.02)

    def off_frame(self) -> bytes:
        """Return the bytes that switch all servos off."""
        return self.protocol.encode(Packet(0, SketchProtocol.OFF))
