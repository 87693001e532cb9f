"""A virtual robot on a wire: bytes in, bytes out, at times that the caller gives."""

import re
import struct
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError
from gaitsim_hardware.arduino import servo_checksum
from gaitsim_hardware.calibration import Calibration
from gaitsim_robot.rollout import tilt_and_yaw
from gaitsim_wire.body import ServoRobot
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
from gaitsim_wire.tables import IMU, ORIENTATION, RATES, TABLES, Register

GAP = 0.01  # s, silence after which an incomplete packet is dropped
WATCHDOG = 0.2  # s without valid pulses, after which the sketch switches the servos off
SAG = 0.2  # share of the voltage that the battery loses at the stall torque of all servos
FAULTS = ("dead", "weak", "hot", "twin", "reversed", "battery", "tipped")
ALLOWED = (
    "JOINT dead, JOINT weak SHARE, JOINT hot °C, JOINT twin, JOINT reversed, battery VOLTS, or "
    "tipped; with 'at SECONDS' for later, such as 'L2 femur dead at 10'"
)


@dataclass(frozen=True)
class Fault:
    """A fault of the robot.

    Attributes:
        kind: one of `FAULTS`.
        joint: number of the joint; −1 for the whole robot.
        value: share of the torque, temperature or voltage.
        at: time from which it acts, s.
    """

    kind: str
    joint: int = -1
    value: float = 0.0
    at: float = 0.0


def parse_fault(text: str, joints: Sequence[str]) -> Fault:
    """Return the fault in a text such as 'L2 femur dead at 10'.

    Raises:
        GaitsimError: the text is invalid.
    """
    number = r"\d+(?:\.\d+)?"
    pattern = rf"(?:(.+) )?({'|'.join(FAULTS)})(?: ({number}))?(?: at ({number}))?"
    found = re.fullmatch(pattern, text.strip())
    joint, kind, value, at = found.groups() if found else ("", "", None, None)
    whole, valued = kind in ("battery", "tipped"), kind in ("weak", "hot", "battery")
    known = joint is None if whole else joint in joints
    if not (found and known and valued == (value is not None)):
        raise GaitsimError(
            f"invalid fault: {text!r}",
            where="--fault",
            allowed=f"{ALLOWED}; joints: {', '.join(joints)}",
        )
    place = -1 if whole else joints.index(joint or "")
    return Fault(kind, place, float(value or 0), float(at or 0))


@dataclass
class Noise:
    """Losses on the wire, drawn for each frame in each direction.

    Attributes:
        dropped: share of frames that are lost.
        corrupted: share of frames in which a byte is changed, lost or inserted.
        rng: source of the draws.
    """

    dropped: float = 0.0
    corrupted: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def spoil(self, frame: bytes) -> bytes:
        """Return a frame as it arrives."""
        if not frame or not (self.dropped or self.corrupted):
            return frame
        drawn = self.rng.random()
        if drawn < self.dropped:
            return b""
        if drawn >= self.dropped + self.corrupted:
            return frame
        at, kind = self.rng.integers(len(frame)), self.rng.integers(3)
        other = bytes([(frame[at] + self.rng.integers(1, 256)) % 256])
        return frame[:at] + (b"", other, other + frame[at : at + 1])[kind] + frame[at + 1 :]


class Emulator(ABC):
    """A robot behind a serial port; time never passes by itself.

    Args:
        body: body of the robot.
        calibration: servos of its joints.
        faults: faults of the robot.
        noise: losses on the wire.

    Attributes:
        body: body of the robot.
        volts: voltage of the battery without load, V.
        tripped: whether a watchdog has stopped the servos.
    """

    protocol: Protocol

    def __init__(
        self,
        body: ServoRobot,
        calibration: Calibration,
        faults: Sequence[Fault] = (),
        noise: Noise | None = None,
    ) -> None:
        self.body, self._calibration = body, calibration
        self._noise = noise or Noise()
        self._faults = sorted(faults, key=lambda fault: fault.at)
        self._dead = np.zeros(len(body.on), dtype=np.bool_)
        self._reversed = np.ones(len(body.on))
        self._twins: set[int] = set()
        self._received, self._heard, self._began = bytearray(), 0.0, -1.0
        self.volts, self.tripped = 0.0, False

    def exchange(self, received: bytes, now: float) -> bytes:
        """Let time pass, receive bytes, and return the bytes of the replies.

        Args:
            received: bytes that arrive at the time `now`.
            now: time on any clock, s; never before that of an earlier call.
        """
        if self._began < 0:
            self._began = now
        seconds = now - self._began
        while self._faults and self._faults[0].at <= seconds:
            self.inject(self._faults.pop(0))
        self._watch(seconds)
        self.body.on &= ~self._dead
        self.body.advance(seconds)
        if not received:
            return b""
        if seconds - self._heard > GAP:
            self._received.clear()
        self._heard = seconds
        self._received += self._noise.spoil(received)
        replies = []
        for packet in self.protocol.take(self._received):
            replies += [self._noise.spoil(reply) for reply in self._answer(packet, seconds)]
        return b"".join(replies)

    def inject(self, fault: Fault) -> None:
        """Let a fault act from now on."""
        joint, body = fault.joint, self.body
        match fault.kind:
            case "dead":
                self._dead[joint] = True
            case "weak":
                body.strength[joint] = fault.value
            case "hot":
                body.temperature[joint] = fault.value
            case "twin":
                self._twins.add(joint)
            case "reversed":
                self._reversed[joint] = -1.0
            case "battery":
                self.volts = fault.value
            case "tipped":
                body.turn_over()

    @abstractmethod
    def _answer(self, packet: Packet, seconds: float) -> list[bytes]:
        """Carry out a packet, and return the frames of the replies."""

    @abstractmethod
    def _watch(self, seconds: float) -> None:
        """Stop the servos if the watchdog has heard nothing for long."""

    @property
    def _voltage(self) -> float:
        return self.volts * (1 - SAG * float(np.abs(self.body.load).mean()))

    @property
    def _degrees(self) -> NDArray[np.float64]:
        """Angle of each servo, (joints,) °."""
        return self._reversed * self._calibration.servo_angles(self.body.angles)

    def _command(self, joint: int, degrees: NDArray[np.float64]) -> None:
        """Give a servo the goal in an array of the angles of all servos, (joints,) °."""
        goals = self._calibration.joint_angles(self._reversed * degrees)
        self.body.goal[joint] = goals[joint]


class EmulatedBus(Emulator):
    """A robot whose servos share a bus, with an IMU as that of an OpenCR board.

    Args:
        bus: 'feetech' or 'dynamixel'.
        imu: whether an IMU answers.
        others: as in `Emulator`.
    """

    def __init__(
        self,
        bus: str,
        body: ServoRobot,
        calibration: Calibration,
        faults: Sequence[Fault] = (),
        noise: Noise | None = None,
        *,
        imu: bool = True,
    ) -> None:
        super().__init__(body, calibration, faults, noise)
        self.table = table = TABLES[bus]
        self.protocol, self.volts = table.protocol, table.voltage
        self._imu = imu
        servos = [*calibration.joints.values()]
        self._joints = {int(servo.id or 0): joint for joint, servo in enumerate(servos)}
        self._memory = {number: bytearray(256) for number in self._joints}
        goals = calibration.ticks(self._degrees)
        for number, joint in self._joints.items():
            self._set(number, table.model, table.models[servos[joint].servo])
            self._set(number, table.mode, table.position_mode)
            self._set(number, table.most, 4095)
            self._set(number, table.goal, int(goals[joint]))

    def _set(self, number: int, part: Register, value: int) -> None:
        memory, at = self._memory[number], part.address
        memory[at : at + part.size] = part.write(value)

    def _get(self, number: int, part: Register) -> int:
        return part.read(self._memory[number], 0)

    def inject(self, fault: Fault) -> None:
        """Let a fault act from now on."""
        super().inject(fault)
        if fault.kind == "reversed" and self.table.reverse:
            number = [*self._joints][fault.joint]
            self._set(number, self.table.reverse, 1)

    def _watch(self, seconds: float) -> None:
        watchdog = self.table.watchdog
        for number, joint in self._joints.items() if watchdog else ():
            assert watchdog is not None
            limit = self._memory[number][watchdog.address]
            if 0 < limit < 128 and seconds - self._heard > limit * 0.02:
                self._memory[number][watchdog.address] = 255
                self.body.goal[joint] = self.body.angles[joint]
                self.tripped = True

    def _answer(self, packet: Packet, seconds: float) -> list[bytes]:
        """Carry out a packet, and return the frames of the replies."""
        data, word, numbers = packet.data, self.protocol.word, [packet.id]
        if packet.id == ALL:
            numbers = [*self._memory]
        if packet.kind in (SYNC_READ, SYNC_WRITE) and len(data) >= 2 * word:
            first, length = (int.from_bytes(data[at : at + word], "little") for at in (0, word))
            rest = data[2 * word :]
            if packet.kind == SYNC_READ:
                return [*filter(None, (self._read(number, first, length) for number in rest))]
            for at in range(0, len(rest) - length, 1 + length):
                self._write(rest[at], first, rest[at + 1 : at + 1 + length])
            return []
        replies = []
        for number in numbers:
            reply = self._one(number, packet)
            if reply and (packet.id != ALL or (packet.kind == PING and word == 2)):
                replies.append(reply)
        return replies

    def _one(self, number: int, packet: Packet) -> bytes:
        """Carry out an instruction to one servo; return the frame of the reply, or b''."""
        word, data = self.protocol.word, packet.data
        kind, place = packet.kind, int.from_bytes(data[:word], "little")
        if kind == PING:
            # Protocol 2.0 replies with the model and the version of the firmware.
            return self._read(number, 0, 3) if word == 2 else self._reply(number)
        if kind == READ and len(data) == 2 * word:
            return self._read(number, place, int.from_bytes(data[word:], "little"))
        error = 0
        if kind == WRITE:
            error = self._write(number, place, data[word:])
        return self._reply(number, error)

    def _reply(self, number: int, error: int = 0, data: bytes = b"") -> bytes:
        """Return the frame of a reply; b'' if nothing answers, spoilt if two servos do."""
        joint = self._joints.get(number)
        if joint is None and not (number == IMU and self._imu):
            return b""
        if joint is not None and self._dead[joint]:
            return b""
        frame = self.protocol.encode(Packet(number, error, data), reply=True)
        return frame[:-1] + bytes([frame[-1] ^ 0x55]) if joint in self._twins else frame

    def _read(self, number: int, first: int, length: int) -> bytes:
        if number in self._joints:
            return self._reply(number, 0, self._present(number)[first : first + length])
        if not self._imu or number != IMU:
            return b""
        table = bytearray(256)
        struct.pack_into("<3f", table, RATES, *self.body.rates)
        struct.pack_into("<4f", table, ORIENTATION, *self.body.orientation)
        return self._reply(number, 0, bytes(table[first : first + length]))

    def _present(self, number: int) -> bytes:
        """Return the memory of a servo with its present values."""
        table, body, joint = self.table, self.body, self._joints[number]
        ticks = self._calibration.ticks(self._degrees)
        direction = self._reversed[joint] * [*self._calibration.joints.values()][joint].direction
        self._set(number, table.position, int(ticks[joint]))
        self._set(number, table.load, int(np.rint(1000 * direction * body.load[joint])))
        self._set(number, table.volts, int(np.rint(10 * self._voltage)))
        self._set(number, table.temperature, int(np.rint(body.temperature[joint])))
        return bytes(self._memory[number])

    def _write(self, number: int, first: int, data: bytes) -> int:
        """Write into the memory of a servo; return the error."""
        joint, table = self._joints.get(number, -1), self.table
        if joint < 0 or self._dead[joint] or first + len(data) > 256:
            return 0
        memory, before = self._memory[number], bytes(self._memory[number])
        memory[first : first + len(data)] = data
        stopped = table.watchdog and before[table.watchdog.address] == 255
        goal = self._get(number, table.goal)
        if not self._get(number, table.least) <= goal <= self._get(number, table.most) or stopped:
            at = table.goal.address
            memory[at : at + table.goal.size] = before[at : at + table.goal.size]
            if first <= at < first + len(data):
                return 6 if self.protocol.word == 2 else 0
        turned_on = memory[table.torque.address] and not self.body.on[joint]
        self.body.on[joint] = bool(memory[table.torque.address])
        if turned_on or first <= table.goal.address < first + len(data):
            positions = np.full(len(self.body.goal), self._get(number, table.goal))
            self._command(joint, self._calibration.angles_of_ticks(positions))
        return 0


STATE = struct.Struct("<BBIHhhi3hB")
"""Status of the sketch: state, joints, checksum of the servos, voltage in mV (0 if unknown), roll
and pitch in 0.1 mrad, yaw in 0.1 mrad, rates in mrad/s, and whether the sensor answers."""
OFF, ON, TRIPPED = range(3)


class SketchBoard(Emulator):
    """A microcontroller with the sketch `receiver.ino`, hobby servos and an MPU6050."""

    protocol = SketchProtocol()

    def __init__(
        self,
        body: ServoRobot,
        calibration: Calibration,
        faults: Sequence[Fault] = (),
        noise: Noise | None = None,
    ) -> None:
        super().__init__(body, calibration, faults, noise)
        self.volts, self._state, self._pulsed, self._yaw = 6.0, OFF, 0.0, 0.0

    def _watch(self, seconds: float) -> None:
        if self._state == ON and seconds - self._pulsed > WATCHDOG:
            self._state, self.tripped = TRIPPED, True
            self.body.on[:] = False

    def _answer(self, packet: Packet, seconds: float) -> list[bytes]:
        """Carry out a packet, and return the frame of the status."""
        if packet.kind == SketchProtocol.HELLO:
            self._state, self._yaw = OFF, 0.0
            self.body.on[:] = False
        elif packet.kind == SketchProtocol.OFF:
            self._state = OFF
            self.body.on[:] = False
        elif (
            packet.kind == SketchProtocol.PULSES
            and self._state != TRIPPED
            and len(packet.data) == 2 * len(self.body.on)
        ):
            self._state, self._pulsed = ON, seconds
            self._move(np.frombuffer(packet.data, "<u2") / 10)
        roll, pitch, yaw = tilt_and_yaw(self.body.orientation)
        self._yaw += (yaw - self._yaw + np.pi) % (2 * np.pi) - np.pi
        tilt = np.rint(1e4 * np.array([roll, pitch, self._yaw])).astype(int)
        rates = np.rint(1e3 * np.clip(self.body.rates, -30, 30)).astype(int)
        volts, joints = round(1000 * self._voltage), len(self.body.on)
        checksum = servo_checksum(self._calibration)
        data = STATE.pack(self._state, joints, checksum, volts, *tilt, *rates, 1)
        status = Packet(packet.id, SketchProtocol.STATUS, data)
        return [self.protocol.encode(status, reply=True)]

    def _move(self, pulses: NDArray[np.float64]) -> None:
        """Drive each servo by its pulse, (joints,) µs; 0 switches it off."""
        calibration = self._calibration
        low, high = (calibration.pulses(one) for one in (calibration.low, calibration.high))
        degrees = calibration.angles_of_pulses(np.clip(pulses, low, high))
        self.body.on[:] = pulses > 0
        for joint in np.flatnonzero(pulses):
            self._command(int(joint), degrees)
