"""The control tables of bus servos: addresses of the values that gaitsim reads and writes."""

from collections.abc import Mapping
from dataclasses import dataclass

from gaitsim_wire.packets import DynamixelProtocol, FeetechProtocol, Protocol


@dataclass(frozen=True)
class Register:
    """A value in a control table, its lowest byte first.

    Attributes:
        address: address of the first byte.
        size: number of bytes.
        sign: bit of the sign of a magnitude; −1 for two's complement.
    """

    address: int
    size: int = 1
    sign: int = -1

    def write(self, value: int) -> bytes:
        """Return the bytes of a value."""
        if self.sign >= 0 and value < 0:
            value = -value | 1 << self.sign
        return (value % (1 << 8 * self.size)).to_bytes(self.size, "little")

    def read(self, table: bytes | bytearray, first: int = 0) -> int:
        """Return the value in bytes that begin at the address `first` of a table."""
        at = self.address - first
        found = int.from_bytes(table[at : at + self.size], "little")
        if self.sign >= 0:
            return -(found & ~(1 << self.sign)) if found >> self.sign & 1 else found
        top = 1 << 8 * self.size
        return found - top if self.size > 1 and 2 * found >= top else found


@dataclass(frozen=True)
class ControlTable:
    """The control table of a family of servos.

    Sources: Feetech, memory table of STS3215; ROBOTIS e-Manual, XL430-W250.

    Attributes:
        protocol: protocol of the bus.
        models: model number by the name of the servo.
        bauds: baud rates of the servos, the usual one first.
        voltage: nominal voltage of the virtual battery, V.
        fields: values by name. `mode` must be `position`; `load` is in 0.1 %, and `volts` in 0.1 V.
        position: mode of position control.
        reverse: field whose lowest bit turns the direction around; None without one.
        watchdog: field of the bus watchdog, in 20 ms; None without one.
    """

    protocol: Protocol
    models: Mapping[str, int]
    bauds: tuple[int, ...]
    voltage: float
    model: Register
    mode: Register
    position_mode: int
    least: Register
    most: Register
    torque: Register
    goal: Register
    position: Register
    load: Register
    volts: Register
    temperature: Register
    reverse: Register | None = None
    watchdog: Register | None = None

    @property
    def watched(self) -> tuple[int, int]:
        """Address and length of the block with position, load, voltage and temperature."""
        parts = self.position, self.load, self.volts, self.temperature
        first = min(part.address for part in parts)
        return first, max(part.address + part.size for part in parts) - first


TABLES = {
    "feetech": ControlTable(
        FeetechProtocol(),
        {"sts3215": 777},
        (1_000_000, 500_000, 115_200, 38_400),
        7.4,
        model=Register(3, 2),
        mode=Register(33),
        position_mode=0,
        least=Register(9, 2, 15),
        most=Register(11, 2, 15),
        torque=Register(40),
        goal=Register(42, 2, 15),
        position=Register(56, 2, 15),
        load=Register(60, 2, 10),
        volts=Register(62),
        temperature=Register(63),
    ),
    "dynamixel": ControlTable(
        DynamixelProtocol(),
        {"xl430-w250": 1060},
        (1_000_000, 57_600, 115_200, 2_000_000, 3_000_000, 4_000_000),
        11.1,
        model=Register(0, 2),
        mode=Register(11),
        position_mode=3,
        least=Register(52, 4),
        most=Register(48, 4),
        torque=Register(64),
        goal=Register(116, 4),
        position=Register(132, 4),
        load=Register(126, 2),
        volts=Register(144, 2),
        temperature=Register(146),
        reverse=Register(10),
        watchdog=Register(98),
    ),
}
"""Control tables by bus."""

IMU = 200
"""Id of an IMU on a servo bus.

It is read as that of ROBOTIS's OpenCR board on a TurtleBot3: angular velocity at the address 60,
three floats in rad/s, and orientation at 96, four floats, a quaternion w, x, y, z.
"""
RATES, ORIENTATION = 60, 96
IMU_LENGTH = ORIENTATION + 16 - RATES
