"""Virtual robots: packets, faults, losses, the sketch's board, and the command."""

import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings, strategies
from wires import quadruped, robot_on

from gaitsim.errors import GaitsimError
from gaitsim_wire.emulator import OFF, ON, STATE, TRIPPED, Fault, Noise, parse_fault
from gaitsim_wire.packets import (
    READ,
    DynamixelProtocol,
    FeetechProtocol,
    Packet,
    SketchProtocol,
    crc16,
)
from gaitsim_wire.robots import calibration_of
from gaitsim_wire.tables import Register

PROTOCOLS = FeetechProtocol(), DynamixelProtocol(), SketchProtocol()
packets = strategies.builds(
    Packet, strategies.integers(0, 253), strategies.integers(1, 100),
    strategies.lists(strategies.sampled_from([0, 1, 0xFD, 0xFF, 0xA5, 0x5A]), max_size=40)
    .map(bytes),
)  # fmt: skip


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("reply", [False, True])
@settings(max_examples=25)
@given(sent=strategies.lists(packets, max_size=4), size=strategies.integers(1, 9))
def test_packets_arrive_however_they_are_split(protocol, reply, sent, size):
    wire = b"".join(protocol.encode(packet, reply=reply) for packet in sent)
    received, found = bytearray(), []
    for at in range(0, len(wire), size):
        received += wire[at : at + size]
        found += protocol.take(received, reply=reply)
    assert found == sent


@pytest.mark.parametrize("protocol", PROTOCOLS)
@settings(max_examples=25)
@given(sent=packets, at=strategies.integers(0, 100), change=strategies.integers(1, 255))
def test_a_changed_byte_never_gives_another_packet(protocol, sent, at, change):
    wire = bytearray(protocol.encode(sent))
    wire[at % len(wire)] ^= change
    found = [*protocol.take(wire, final=True)]
    # A sum of bytes finds any one changed byte, but rarely two parts of a frame look like one.
    assert not found or found == [sent] or isinstance(protocol, FeetechProtocol)


def test_frames_behind_a_wrong_length_are_found_in_the_end():
    protocol = FeetechProtocol()
    wire = bytearray(protocol.encode(Packet(1, 0)) + protocol.encode(Packet(2, 0)))
    wire[3] = 200
    assert not [*protocol.take(wire, reply=True)]
    assert [*protocol.take(wire, reply=True, final=True)] == [Packet(2, 0)]


def test_known_frames():
    # The example of a ping in ROBOTIS's e-Manual, and of Feetech's manual.
    assert DynamixelProtocol().encode(Packet(1, 1)) == bytes.fromhex("fffffd00010300 01194e")
    assert crc16(bytes.fromhex("fffffd00010300 01")) == 0x4E19
    assert FeetechProtocol().encode(Packet(1, 1)) == bytes.fromhex("ffff010201fb")


def test_fields_have_their_signs():
    assert Register(60, 2, 10).write(-5) == b"\x05\x04"
    assert Register(60, 2, 10).read(b"\x05\x04", 60) == -5
    assert Register(126, 2).read(Register(126, 2).write(-5), 126) == -5
    assert Register(63).read(b"\xc8", 63) == 200


def test_the_same_bytes_at_the_same_times_give_the_same_replies():
    replies = []
    for _ in range(2):
        robot = robot_on("feetech", noise=Noise(0.1, 0.3, np.random.default_rng(5)))
        ask = robot.protocol.encode(Packet(254, 0x82, bytes([56, 8, *range(1, 13)])))
        goal = robot.protocol.encode(Packet(3, 3, bytes([40, 1, 0, 0, 8])))
        replies.append([robot.exchange(goal + ask, step * 0.02) for step in range(30)])
    assert replies[0] == replies[1]
    assert len({*map(len, replies[0])}) > 1, "some frames were lost"


def test_horns_are_mounted_with_errors_that_servos_do_not_feel():
    straight, wrong = robot_on("feetech"), robot_on("feetech", joint_offset=8.0, seed=1.0)
    for robot in (straight, wrong):
        robot.exchange(b"", 0)
        robot.body.hold()
        robot.body.goal[:] = quadruped().organism.standing_pose()
        robot.body.on[:] = True
        robot.exchange(b"", 1.0)
    error = quadruped(joint_offset=8.0, seed=1.0).organism.simulation.offset
    apart = np.abs(straight.body.angles - wrong.body.angles)
    assert np.degrees(np.abs(error)).max() > 8
    assert np.degrees(apart).max() < 5


def test_servos_warm_under_load_and_weak_ones_yield():
    robot = robot_on("feetech", Fault("weak", 2, 0.0))
    standing = quadruped().organism.standing_pose()
    robot.exchange(b"", 0)
    robot.body.goal[:], robot.body.on[:] = standing, True
    for step in range(1, 100):
        robot.exchange(b"", 0.02 * step)
    assert robot.body.temperature.max() > 25.0
    assert abs(robot.body.angles[2] - standing[2]) > 0.1
    assert robot.body.load[2] == 0


def told(robot, packet, now):
    [status] = robot.protocol.take(bytearray(robot.exchange(robot.protocol.encode(packet), now)))
    assert status.id == packet.id
    return STATE.unpack(status.data)


def test_the_board_switches_servos_off_when_pulses_stop():
    robot = robot_on("serial")
    state, joints, _, volts, *_ = told(robot, Packet(7, SketchProtocol.HELLO), 0.0)
    assert (state, joints, volts) == (OFF, 12, 6000)
    pulses = np.full(12, 15000, "<u2").tobytes()
    assert told(robot, Packet(8, SketchProtocol.PULSES, pulses), 0.1)[0] == ON
    assert robot.body.on.all()
    assert told(robot, Packet(9, SketchProtocol.STATUS), 0.2)[0] == ON, "but no pulses"
    assert told(robot, Packet(9, SketchProtocol.STATUS), 0.4)[0] == TRIPPED
    assert not robot.body.on.any()
    assert told(robot, Packet(8, SketchProtocol.PULSES, pulses), 0.5)[0] == TRIPPED, (
        "until it is greeted"
    )
    told(robot, Packet(8, SketchProtocol.HELLO), 0.6)
    assert told(robot, Packet(8, SketchProtocol.PULSES, pulses[:2] + bytes(22)), 0.7)[0] == ON
    assert [*np.flatnonzero(robot.body.on)] == [0]
    assert told(robot, Packet(8, SketchProtocol.OFF), 0.8)[0] == OFF
    assert not robot.body.on.any()


def test_faults_are_parsed():
    joints = quadruped().organism.joint_names()
    assert parse_fault("L1 knee dead at 10", joints) == Fault(
        "dead", joints.index("L1 knee"), 0, 10
    )
    assert parse_fault("battery 5.5", joints) == Fault("battery", -1, 5.5)
    for text in ("L9 knee dead", "L1 knee", "L1 knee hot", "battery", "L1 knee dead 5", "dead"):
        with pytest.raises(GaitsimError, match="invalid fault"):
            parse_fault(text, joints)


def test_servos_of_another_bus_are_refused():
    robot = quadruped().organism.model_copy(update={"servo": "ax-12a"})
    with pytest.raises(GaitsimError, match=r"'ax-12a' of .* cannot be driven"):
        calibration_of(robot, "dynamixel", None)


@pytest.mark.parametrize("option", ["--baud 12345", "--fault broken", "--world moon=1"])
def test_invalid_options_are_explained(gaitsim, option):
    said = gaitsim("robots", "emulate", "quadruped", *option.split(), code=2).stderr
    assert "allowed:" in said


def test_bodies_without_servos_are_refused(gaitsim):
    assert "no servos in MuJoCo" in gaitsim("robots", "emulate", "millipede", code=2).stderr


@pytest.mark.slow
def test_the_command_serves_a_port_at_its_baud_rate(tmp_path):
    serial = pytest.importorskip("serial")
    words = [sys.executable, "-m", "gaitsim", "robots", "emulate", "quadruped", "--link", "port"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert (
                process.stdout.readline() == "port: quadruped, feetech, 12 servos, 1000000 baud\n"
            )
            ask = FeetechProtocol().encode(Packet(3, READ, bytes([3, 2])))
            for baud, expected in (
                (57600, b""),
                (1_000_000, FeetechProtocol().encode(Packet(3, 0, b"\t\3"))),
            ):
                with serial.Serial(str(tmp_path / "port"), baud, timeout=0.5) as port:
                    port.write(ask)
                    assert port.read(8) == expected
        finally:
            process.terminate()
        assert re.search("The robot moved", process.stdout.read())
    assert process.returncode == 0
    assert not (tmp_path / "port").is_symlink()
