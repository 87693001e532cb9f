"""`gaitsim drive` in a terminal, with a virtual robot on a pseudo-terminal in another process."""

import os
import pty
import signal
import subprocess
import sys
import time
from select import select

import pytest

from gaitsim_wire.packets import READ, FeetechProtocol, Packet

serial = pytest.importorskip("serial")
GAITSIM = [sys.executable, "-m", "gaitsim"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a run, its calibration, and the port of a virtual robot."""
    folder = tmp_path_factory.mktemp("drive")
    run = ["run", "quadruped", "--generations", "1", "--population", "4"]
    template = ["export", "quadruped", "--format", "feetech"]
    template += ["--calibration-template", "robot.toml"]
    for words in ([*run, "--set", "organism.duration=2"], template):
        subprocess.run([*GAITSIM, *words], cwd=folder, check=True, capture_output=True)
    words = [*GAITSIM, "robots", "emulate", "quadruped", "--link", "port"]
    with subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        yield folder
        process.terminate()


@pytest.fixture
def drive(folder):
    """Start a drive in a pseudo-terminal until the robot walks; return it and the terminal."""
    terminals = []

    def begin(*words):
        words = ["drive", "quadruped", "--port", "port", "--calibration", "robot.toml", *words]
        for attempt in range(3):
            master, inside = pty.openpty()
            process = subprocess.Popen(
                [*GAITSIM, *words], cwd=folder, stdin=inside, stdout=inside, stderr=inside,
                start_new_session=True,
            )  # fmt: skip
            os.close(inside)
            terminals.append((process, master))
            try:
                return process, master, until(master, "driving")
            except OSError:  # a busy machine kept the virtual robot silent for 0.2 s
                if attempt == 2:
                    raise
        raise AssertionError

    yield begin
    for process, _ in terminals:
        process.kill()
        process.wait()


def until(master, text):
    """Read a terminal until it shows a text; return all that it showed."""
    seen, end = "", time.monotonic() + 60
    while text not in seen:
        assert time.monotonic() < end, seen
        if select([master], [], [], 0.2)[0]:
            seen += os.read(master, 65536).decode()
    return seen


def torque_off(folder):
    """Wait until the port is free, and return whether the torque of the first servo is off."""
    ask, end = FeetechProtocol().encode(Packet(1, READ, bytes([40, 1]))), time.monotonic() + 5
    while True:
        try:
            with serial.Serial(str(folder / "port"), 1_000_000, timeout=2, exclusive=True) as port:
                port.write(ask)
                return port.read(7) == FeetechProtocol().encode(Packet(1, 0, b"\0"))
        except serial.SerialException:
            assert time.monotonic() < end, "the port is not freed"


@pytest.mark.slow
def test_keys_steer_and_q_lies_down(drive, folder):
    process, master, seen = drive()
    assert "Space: servos off at once" in seen
    os.write(master, b"\x1b[A\x1b[A")
    assert "voltage 7." in until(master, "set speed 0.09")
    os.write(master, b"q")
    seen = until(master, "Compare it with the simulation")
    assert "The robot has lain down" in seen
    assert process.wait(5) == 0
    assert torque_off(folder)
    recording = folder / "runs" / "quadruped" / "exports" / "robot-1.npz"
    words = [*GAITSIM, "analyse", "quadruped", "--gait", str(recording)]
    subprocess.run(words, cwd=folder, check=True, capture_output=True)


@pytest.mark.slow
@pytest.mark.parametrize("end", ["space", "kill", "term", "hangup", "suspend"])
def test_the_servos_are_off_however_the_drive_ends(drive, folder, end):
    process, master, _ = drive("--walk")
    match end:
        case "space":
            os.write(master, b" ")
            assert "Stopped: Space was pressed" in until(master, "servos are off")
            assert process.wait(10) == 1
        case "kill":
            process.kill()
        case "term":
            process.send_signal(signal.SIGTERM)
            assert process.wait(10) == 130
        case "suspend":
            process.send_signal(signal.SIGTSTP)
            assert "Stopped: Ctrl-Z was pressed" in until(master, "servos are off")
            assert process.wait(10) == 1
        case "hangup":
            os.close(master)
            assert process.wait(10) == 2, "its last lines cannot be written"
    assert torque_off(folder)


@pytest.mark.slow
def test_ports_that_cannot_be_driven_are_explained(folder, gaitsim, monkeypatch):
    monkeypatch.chdir(folder)

    def said(port, *words):
        arguments = ["--port", port, "--calibration", "robot.toml", "--seconds", "1", *words]
        return gaitsim("drive", "quadruped", *arguments, code=2).stderr

    assert "there is no port nowhere" in said("nowhere")
    assert "cannot open robot.toml" in said("robot.toml")
    with serial.Serial("port", 1_000_000, exclusive=True):
        assert "another program uses port" in said("port")
    assert "--baud 1000000" in said("port", "--baud", "500000")

    def refused(*_, **__):
        raise serial.SerialException(13, "Permission denied")

    monkeypatch.setattr(serial, "Serial", refused)
    assert "no permission to open port" in said("port")
    assert "usermod -aG" in said("port")
