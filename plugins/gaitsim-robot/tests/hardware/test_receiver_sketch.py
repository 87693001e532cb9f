"""The sketch that plays pulses that a program sends, compiled with stubs of the headers and run."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from varied_servos import calibrate

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim_hardware.arduino import create_receiver_sketch, servo_checksum, write_sketch
from gaitsim_wire.emulator import OFF, ON, STATE, TRIPPED
from gaitsim_wire.packets import Packet, SketchProtocol

STUBS = Path(__file__).parent / "stubs"
CXX = shutil.which("g++") or shutil.which("clang++")
NAMES = ("L1 hip", "L1 knee", "R1 hip")
CALIBRATION = calibrate(NAMES, min=-45.0, max=60.0)
PROTOCOL = SketchProtocol()


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    """Return a function that runs the sketch with bytes at times, and returns its actions.

    They are the states in replies and the pulses of each servo, µs, both with their times in ms.
    """
    if CXX is None:
        pytest.skip("no C++ compiler")
    folder = tmp_path_factory.mktemp("sketch")
    walk, program = folder / "walk", str(folder / "play")
    write_sketch(create_receiver_sketch(CALIBRATION, "walk", "a robot"), walk)
    flags = ["-Wall", "-Wextra", "-Werror", "-DARDUINO=10819", f"-I{STUBS}", f"-I{walk}"]
    sketch = [f'-DSKETCH="{walk / "walk.ino"}"', "-x", "c++", str(STUBS / "receive.cpp")]
    subprocess.run([CXX, "-std=c++17", *flags, *sketch, "-o", program], check=True)
    places = [(0x40 + joint.board, joint.channel) for joint in CALIBRATION.joints.values()]

    def run(*told):
        lines = "".join(
            f"{time} {one if one == '!' else one.hex()}\n"
            for time, one in zip(told[::2], told[1::2], strict=True)
        )
        output = subprocess.run([program], input=lines, check=True, capture_output=True, text=True)
        states, pulses = [], []
        for line in output.stdout.splitlines():
            first, *rest = line.split()
            if first == "reply":
                [packet] = PROTOCOL.take(bytearray.fromhex(rest[1]))
                states.append((int(rest[0]), packet.id, *STATE.unpack(packet.data)))
            else:
                place, ticks = tuple(map(int, rest[:2])), int(rest[2])
                us = None if ticks == 4096 else ticks / 4096 * 20_000
                pulses.append((int(first), places.index(place), us))
        return states, pulses

    return run


def frame(kind, data=b"", number=1):
    return PROTOCOL.encode(Packet(number, kind, data))


def pulses_of(*us):
    return np.array(us, "<u2").tobytes()


def test_it_plays_pulses_within_limits_and_says_who_it_is(board):
    told = pulses_of(15000, 60000, 0)
    states, pulses = board(
        1500, frame(SketchProtocol.HELLO), 1600, frame(SketchProtocol.PULSES, told, 9), 1601, b""
    )
    assert [(one[0], one[1], one[2]) for one in states] == [(1500, 1, OFF), (1600, 9, ON)]
    assert states[0][3:6] == (3, servo_checksum(CALIBRATION), 0)
    driven = {joint: us for time, joint, us in pulses if time == 1600}
    assert driven[0] == pytest.approx(1500, abs=5)
    highest = CALIBRATION.pulses(CALIBRATION.high)[1]
    assert driven[1] == pytest.approx(highest, abs=5)
    assert driven[2] is None


def test_it_switches_off_without_pulses_until_it_is_greeted(board):
    told = frame(SketchProtocol.PULSES, pulses_of(15000, 15000, 15000))
    states, pulses = board(
        100, frame(SketchProtocol.HELLO), 200, told, 300, frame(SketchProtocol.STATUS),
        450, told, 500, frame(SketchProtocol.HELLO), 510, told, 550, frame(SketchProtocol.OFF),
        560, b"",
    )  # fmt: skip
    assert [one[2] for one in states] == [OFF, ON, ON, TRIPPED, OFF, ON, OFF]
    assert [time for time, _, us in pulses if us is None and 300 < time < 500] == [401, 401, 401]
    assert all(us is None for time, _, us in pulses if 401 <= time < 510)
    assert all(us is None for time, _, us in pulses if time >= 550)


def test_wrong_bytes_move_nothing(board):
    rng, told, right = np.random.default_rng(3), [50, frame(SketchProtocol.HELLO)], set()
    for number in range(120):
        data = bytearray(
            frame(SketchProtocol.PULSES, pulses_of(*[15000 + 10 * number] * 3), number)
        )
        if number % 3:
            data[rng.integers(len(data))] ^= rng.integers(1, 256)
            if number % 3 == 2:
                del data[rng.integers(len(data))]
        else:
            right.add(number)
        told += [60 + 20 * number, bytes(data)]
    states, pulses = board(*told, 3000, b"")
    assert {one[1] for one in states[1:]} == right
    on = [us for time, joint, us in pulses if us is not None and joint == 0]
    expected = [1500 + number for number in sorted(right)]
    assert on == pytest.approx(expected, abs=5)


def test_it_measures_tilt_after_a_second_at_rest(board):
    ask = frame(SketchProtocol.STATUS)
    states, _ = board(500, ask, 1500, ask, 1600, "!", 6000, ask, 6001, b"")
    assert [one[-1] for one in states] == [2, 1, 1]
    assert states[1][6:9] == (0, 0, 0)
    assert states[2][6] == pytest.approx(1e4 * np.pi / 2, rel=0.02)


def test_it_is_exported(tmp_path):
    experiment = gs.load_experiment("quadruped", {"organism.duration": 2.0})
    genome = next(iter(experiment.organism.starts().values()))
    individual = Individual(experiment, 0.0, {}, 1, genome)
    done = gs.export(individual, tmp_path / "walk", "arduino", stream=True)
    assert {path.name for path in (tmp_path / "walk").iterdir()} == {"servos.h", "walk.ino"}
    assert "over USB" in done.summary
    assert "no calibration" in done.notices[0]
    with pytest.raises(GaitsimError, match="--stream cannot be combined with --clip or --speed"):
        gs.export(individual, tmp_path / "walk", "arduino", stream=True, clip=True, speed=0.5)
