"""Programs in a pseudo-terminal, ended by a key or Ctrl-C."""

import os
import pty
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path
from select import select


def shell(line: str, folder: Path) -> dict[str, object]:
    """Return the `subprocess` arguments of a shell line with this installation on its PATH."""
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return {
        "args": ["bash", "-c", line],
        "cwd": folder,
        "env": os.environ | {"PATH": places, "TERM": "xterm-256color"},
    }


def begin_and_end(line: str, folder: Path, shows: str, key: str) -> None:
    """Run a command in a terminal until it shows a text, then end it with a key or Ctrl-C."""
    terminal, inside = pty.openpty()
    termios.tcsetwinsize(inside, (40, 120))
    places = {"stdin": inside, "stdout": inside, "stderr": inside}
    process = subprocess.Popen(**shell(f"exec {line}", folder), **places)  # type: ignore[call-overload]
    os.close(inside)
    seen, end = b"", time.monotonic() + 180
    try:
        while shows.encode() not in seen:
            assert time.monotonic() < end, f"{line}: {seen[-2000:].decode(errors='replace')}"
            seen += _read(terminal)
        if key:
            os.write(terminal, key.encode())
        else:
            process.send_signal(signal.SIGINT)
        while process.poll() is None and time.monotonic() < end:
            seen += _read(terminal)  # a full terminal would block the program
        assert process.poll() in (0, 130), f"{line}: {seen[-2000:].decode(errors='replace')}"
    finally:
        process.kill()
        process.wait()
        os.close(terminal)


def _read(terminal: int) -> bytes:
    """Return the next output of the terminal, or nothing after a short timeout."""
    if not select([terminal], [], [], 0.2)[0]:
        return b""
    try:
        return os.read(terminal, 65536)
    except OSError:  # the program has ended
        return b""
