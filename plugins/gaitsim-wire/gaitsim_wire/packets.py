"""The packets of servo buses and of gaitsim's sketch: bytes to packets, and packets to bytes."""

import zlib
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

PING, READ, WRITE, SYNC_READ, SYNC_WRITE = 1, 2, 3, 0x82, 0x83
"""Instructions, the same on both servo buses."""
ALL = 254  # id to which all servos listen, and none replies


class Packet(NamedTuple):
    """One packet.

    Attributes:
        id: id of the servo; for the sketch, the number of the packet, from 0 to 255.
        kind: instruction; in a reply, the error of the servo, 0 for none.
        data: parameters.
    """

    id: int
    kind: int
    data: bytes = b""


class Protocol(ABC):
    """The frames of packets on a wire.

    Attributes:
        header: first bytes of each frame.
        word: number of bytes of addresses and lengths in parameters.
        overhead: number of bytes of a reply besides its data.
    """

    header: ClassVar[bytes]
    word: ClassVar[int] = 1
    overhead: ClassVar[int]

    @abstractmethod
    def encode(self, packet: Packet, *, reply: bool = False) -> bytes:
        """Return the frame of a packet."""

    @abstractmethod
    def length(self, frame: bytearray) -> int:
        """Return the number of bytes of a frame by its first bytes; 0 if they do not suffice."""

    @abstractmethod
    def decode(self, frame: bytes, *, reply: bool = False) -> Packet | None:
        """Return the packet of a frame; None if its checksum or its form is wrong."""

    def take(
        self, received: bytearray, *, reply: bool = False, final: bool = False
    ) -> Iterator[Packet]:
        """Yield the valid packets in received bytes, and remove them and what is invalid.

        Args:
            received: received bytes, changed in place.
            reply: whether replies are expected, rather than instructions.
            final: whether no more bytes will follow. An incomplete frame, perhaps with a wrong
                length, is then skipped to find those behind it.
        """
        while True:
            start = received.find(self.header)
            if start < 0:
                # The last bytes may be the first part of a header.
                del received[: len(received) - len(self.header) + 1]
                return
            del received[:start]
            length = self.length(received)
            if not length or length > len(received):
                if not final:
                    return
                del received[0]
                continue
            packet = self.decode(bytes(received[:length]), reply=reply)
            del received[: length if packet else 1]
            if packet:
                yield packet


class FeetechProtocol(Protocol):
    """The protocol of Feetech's SCS and STS servos, as of Dynamixel servos before 2.0.

    A frame is FF FF, id, length, kind, data, and the complement of the sum of the bytes after the
    header.
    """

    header = b"\xff\xff"
    overhead = 6

    def encode(self, packet: Packet, *, reply: bool = False) -> bytes:
        """Return the frame of a packet."""
        body = bytes([packet.id, len(packet.data) + 2, packet.kind]) + packet.data
        return self.header + body + bytes([~sum(body) & 0xFF])

    def length(self, frame: bytearray) -> int:
        """Return the number of bytes of a frame by its first bytes; 0 if they do not suffice."""
        if frame[2:3] == b"\xff":  # the header begins a byte later
            return 1
        return frame[3] + 4 if len(frame) > 3 else 0

    def decode(self, frame: bytes, *, reply: bool = False) -> Packet | None:
        """Return the packet of a frame; None if its checksum or its form is wrong."""
        if len(frame) < 6 or frame[2] > ALL or ~sum(frame[2:-1]) & 0xFF != frame[-1]:
            return None
        return Packet(frame[2], frame[4], frame[5:-1])


def _crc_table() -> tuple[int, ...]:
    found = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x8005 if crc & 0x8000 else 0)
        found.append(crc & 0xFFFF)
    return tuple(found)


_TABLE = _crc_table()


def crc16(data: bytes) -> int:
    """Return the checksum of Dynamixel's protocol 2.0: polynomial 8005, start 0."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFFFF) ^ _TABLE[crc >> 8 ^ byte]
    return crc


class DynamixelProtocol(Protocol):
    """Dynamixel's protocol 2.0.

    A frame is FF FF FD 00, id, length, kind, data and a CRC; a reply has the kind 55, and its error
    in front of the data. FF FF FD in the data is followed by another FD.
    """

    header = b"\xff\xff\xfd"
    word = 2
    overhead = 11
    _STUFFED = b"\xff\xff\xfd\xfd"
    _REPLY = 0x55

    def encode(self, packet: Packet, *, reply: bool = False) -> bytes:
        """Return the frame of a packet."""
        body = bytes([self._REPLY, packet.kind] if reply else [packet.kind]) + packet.data
        body = body.replace(self.header, self._STUFFED)
        size = (len(body) + 2).to_bytes(2, "little")
        frame = self.header + bytes([0, packet.id]) + size + body
        return frame + crc16(frame).to_bytes(2, "little")

    def length(self, frame: bytearray) -> int:
        """Return the number of bytes of a frame by its first bytes; 0 if they do not suffice."""
        return int.from_bytes(frame[5:7], "little") + 7 if len(frame) > 6 else 0

    def decode(self, frame: bytes, *, reply: bool = False) -> Packet | None:
        """Return the packet of a frame; None if its checksum or its form is wrong."""
        if len(frame) < 10 + reply or frame[3] or frame[4] > ALL:
            return None
        if int.from_bytes(frame[-2:], "little") != crc16(frame[:-2]):
            return None
        body = frame[7:-2].replace(self._STUFFED, self.header)
        if reply != (body[0] == self._REPLY):
            return None
        return Packet(frame[4], body[1], body[2:]) if reply else Packet(frame[4], body[0], body[1:])


class SketchProtocol(Protocol):
    """The protocol of gaitsim's sketch `receiver.ino`.

    A frame is A5 5A, number, length of the data, kind, data and a CRC-32 of all bytes before it,
    the lowest byte first. The reply has the number of the instruction.
    """

    header = b"\xa5\x5a"
    overhead = 9
    HELLO, PULSES, OFF, STATUS = b"hpos"
    """Kinds: who are you, pulses for all servos, servos off, and a status as the reply to all."""

    def encode(self, packet: Packet, *, reply: bool = False) -> bytes:
        """Return the frame of a packet."""
        head = self.header + bytes([packet.id, len(packet.data), packet.kind])
        body = head + packet.data
        return body + zlib.crc32(body).to_bytes(4, "little")

    def length(self, frame: bytearray) -> int:
        """Return the number of bytes of a frame by its first bytes; 0 if they do not suffice."""
        return frame[3] + 9 if len(frame) > 3 else 0

    def decode(self, frame: bytes, *, reply: bool = False) -> Packet | None:
        """Return the packet of a frame; None if its checksum or its form is wrong."""
        if zlib.crc32(frame[:-4]).to_bytes(4, "little") != frame[-4:]:
            return None
        return Packet(frame[2], frame[4], frame[5:-4])
