"""The terminal of a drive: keys without Enter, a few lines of telemetry, and a watchdog."""

import os
import signal
import subprocess
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import numpy as np

from gaitsim.plugin.commands import echo, results
from gaitsim_robot.steering import COMMANDS
from gaitsim_wire.driving import Player, Status, Stopped

EVERY = 10  # frames between two updates of the telemetry
LINES = 6  # lines of telemetry
ARROWS = {"\x1b[A": "up", "\x1b[B": "down", "\x1b[C": "right", "\x1b[D": "left"}
ARROWS |= {sequence.replace("[", "O"): key for sequence, key in ARROWS.items()}
KEYS = {one.key: one.name for one in COMMANDS if one.key not in ("space", "x")} | {"0": "stop"}
HELP = "Space: servos off at once · 0 stand · arrows, a d, w s: as in 'gaitsim steer' · q: lie down"

_DEADMAN = """
import os, sys
os.read(0, 1)
for _ in range(3): os.write(int(sys.argv[1]), bytes.fromhex(sys.argv[2]))
"""


@contextmanager
def deadman(port: int, off: bytes) -> Iterator[None]:
    """Let another process switch the servos off when this one ends, even if it is killed.

    Args:
        port: descriptor of the open port.
        off: bytes that switch the servos off.
    """
    words = [sys.executable, "-I", "-S", "-c", _DEADMAN, str(port), off.hex()]
    with subprocess.Popen(
        words,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        pass_fds=[port],
        start_new_session=True,
    ) as process:
        try:
            yield
        finally:
            assert process.stdin is not None, "it has a pipe"
            process.stdin.close()


@contextmanager
def raw_keys() -> Iterator[Callable[[], list[str]]]:
    """Yield a function that returns the keys pressed since the last call.

    It raises `Stopped` when the terminal is lost. Ctrl-Z raises it, too, since a suspended program
    could not stop the robot. Without a terminal, there are never keys.
    """
    if not sys.stdin.isatty():
        yield list
        return
    descriptor = sys.stdin.fileno()
    before, blocking = termios.tcgetattr(descriptor), os.get_blocking(descriptor)

    def lost(*_: object) -> None:
        raise Stopped("the terminal was lost")

    def keys() -> list[str]:
        try:
            text = os.read(descriptor, 1024).decode(errors="replace")
        except BlockingIOError:
            return []
        except OSError:
            text = ""
        if not text:
            lost()
        for sequence, key in ARROWS.items():
            text = text.replace(sequence, f"\0{key}\0")
        return [key for part in text.split("\0") for key in ([part] if part in KEYS else part)]

    def suspended(*_: object) -> None:
        raise Stopped("Ctrl-Z was pressed")

    hangup, suspend = signal.signal(signal.SIGHUP, lost), signal.signal(signal.SIGTSTP, suspended)
    try:
        tty.setcbreak(descriptor)
        os.set_blocking(descriptor, False)
        yield keys
    finally:
        signal.signal(signal.SIGHUP, hangup)
        signal.signal(signal.SIGTSTP, suspend)
        with suppress(OSError, termios.error):
            os.set_blocking(descriptor, blocking)
            termios.tcsetattr(descriptor, termios.TCSANOW, before)


def poller(
    player: Player, keys: Callable[[], list[str]], names: tuple[str, ...], seconds: float
) -> Callable[[Status], None]:
    """Return the function that `Session.run` calls in each frame.

    Args:
        player: source of the joint angles.
        keys: function that returns the pressed keys.
        names: names of the joints.
        seconds: time after which the robot lies down, s.
    """
    screen = results()
    shown = screen.isatty()

    def poll(status: Status) -> None:
        for key in keys():
            if key == " ":
                raise Stopped("Space was pressed")
            if key == "q":
                player.stop()
            elif key in KEYS:
                player.give(KEYS[key])
        if status.seconds >= seconds:
            player.stop()
        if shown and status.frames % EVERY == 0:
            lines = telemetry(status, player, names)
            up = f"\x1b[{LINES}A" if status.frames > EVERY else ""
            with suppress(OSError):  # the next keys say that the terminal is lost
                screen.write(up + "".join(f"\x1b[2K{line[:78]}\n" for line in lines))
                screen.flush()

    return poll


def telemetry(status: Status, player: Player, names: tuple[str, ...]) -> list[str]:
    """Return the lines of telemetry."""
    reading = status.reading

    def most(values: np.ndarray[tuple[int], np.dtype[np.float64]], unit: str) -> str:
        if not np.isfinite(values).any():
            return "not measured"
        joint = int(np.nan_to_num(values, nan=-np.inf).argmax())
        return f"{values[joint]:.0f} {unit} ({names[joint]})"

    def known(value: float, unit: str) -> str:
        return f"{value:.1f} {unit}" if np.isfinite(value) else "not measured"

    roll, pitch, yaw = np.degrees(reading.orientation)
    share = status.late / max(status.frames, 1)
    facts = player.facts()
    notice = facts.pop("", "")
    asked = ", ".join(f"{name} {value}" for name, value in facts.items())
    return [
        f"{status.phase:<10} {status.seconds:7.1f} s   late {status.late} ({share:.2%})   "
        f"round trip {1000 * status.round_trip:.1f} ms   at limits {status.clipped}",
        f"hottest {most(reading.temperature, '°C')}   "
        f"highest torque {most(100 * np.abs(reading.load), '%')}",
        f"voltage {known(reading.volts, 'V')}   yaw {known(yaw, '°')}   "
        f"tilt {known(max(abs(roll), abs(pitch)), '°')}",
        asked,
        notice,
        HELP,
    ]


def say(text: str) -> None:
    """Print a line behind the telemetry."""
    with suppress(OSError):  # the terminal may be lost
        echo(text)
