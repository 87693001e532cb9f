"""A virtual robot on a pseudo-terminal, in real time."""

import gc
import os
import pty
import select
import termios
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gaitsim.plugin import GaitsimError
from gaitsim_wire.emulator import Emulator

STEP = 0.005  # s, longest time between two steps of the simulation
REPORT = 0.5  # s, time between two calls of `report`


@contextmanager
def linked(path: str, link: Path | None) -> Iterator[None]:
    """Let a symbolic link point to a path during the block.

    Raises:
        GaitsimError: the link cannot be created.
    """
    if link is not None:
        try:
            if link.is_symlink() and not link.exists():  # left by an emulator that was killed
                link.unlink()
            link.symlink_to(path)
        except OSError as error:
            raise GaitsimError(
                f"cannot create the link {link}: {error.strerror}",
                where="--link",
                allowed="a path that does not exist, in a folder that can be written",
            ) from None
    try:
        yield
    finally:
        if link is not None:
            with suppress(OSError):
                link.unlink()


def serve(
    emulator: Emulator,
    baud: int,
    seconds: float,
    link: Path | None,
    begin: Callable[[str], object],
    report: Callable[[float], object],
) -> None:
    """Run a virtual robot on a new pseudo-terminal until KeyboardInterrupt, or for some seconds.

    Args:
        emulator: the robot.
        baud: baud rate; bytes of a program that has set another one are not understood.
        seconds: duration, s.
        link: symbolic link to create to the port; None for none.
        begin: function called with the path of the port.
        report: function called twice a second with the time, s.
    """
    gc.freeze()  # a collection of all that was loaded takes longer than a robot may be silent
    master, inside = pty.openpty()
    path, speed = os.ttyname(inside), getattr(termios, f"B{baud}")
    try:
        tty.setraw(inside)
        os.set_blocking(master, False)
        with linked(path, link):
            begin(path if link is None else str(link))
            start = told = time.monotonic()
            while (now := time.monotonic()) - start < seconds:
                readable = select.select([master], [], [], STEP)[0]
                received = os.read(master, 65536) if readable else b""
                if received and termios.tcgetattr(inside)[5] != speed:
                    received = b""
                replies = emulator.exchange(received, time.monotonic())
                if replies:
                    with suppress(BlockingIOError):  # nobody reads, as on a real wire
                        os.write(master, replies)
                if now - told >= REPORT:
                    told = now
                    report(now - start)
    finally:
        os.close(master)
        os.close(inside)
