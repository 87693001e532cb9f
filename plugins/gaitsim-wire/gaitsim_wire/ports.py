"""Serial ports: opening one, and the errors that it may give."""

import errno
import os
from pathlib import Path
from typing import Any

from gaitsim.plugin import GaitsimError

BAUDS = (57_600, 115_200, 230_400, 500_000, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
"""Baud rates that both Linux and servo buses know."""


def check_baud(baud: int) -> int:
    """Return a baud rate after checking it."""
    if baud not in BAUDS:
        allowed = ", ".join(map(str, BAUDS))
        raise GaitsimError(f"invalid baud rate: {baud}", where="--baud", allowed=allowed)
    return baud


def open_port(path: str, baud: int) -> Any:
    """Return an open `serial.Serial` that no other program uses, without a timeout.

    Raises:
        GaitsimError: the port cannot be opened.
    """
    import serial

    try:
        return serial.Serial(path, baud, timeout=0, write_timeout=0.5, exclusive=True)
    except (OSError, ValueError) as error:
        raise _cannot_open(path, error) from None


def _cannot_open(path: str, error: Exception) -> GaitsimError:
    """Return the error of a port that cannot be opened."""
    from serial.tools.list_ports import comports

    ports = ", ".join(port.device for port in comports()) or "none was found"
    number = getattr(error, "errno", None)
    if not os.path.exists(path):  # noqa: PTH110
        return GaitsimError(
            f"there is no port {path}",
            where="--port",
            allowed=f"a serial port of this machine: {ports}",
            remedy="connect the adapter, and look at its name with 'ls /dev/tty*'",
        )
    if number == errno.EACCES or isinstance(error, PermissionError):
        return GaitsimError(
            f"no permission to open {path}",
            where="--port",
            allowed=f"users in the group {_group(path)}",
            remedy=f"sudo usermod -aG {_group(path)} $USER, then log out and in again",
        )
    if number in (errno.EAGAIN, errno.EBUSY) or "exclusively lock" in str(error):
        return GaitsimError(
            f"another program uses {path}",
            where="--port",
            remedy=f"close it, such as a serial monitor; 'fuser {path}' names it",
        )
    return GaitsimError(f"cannot open {path}: {error}", where="--port", allowed="a serial port")


def _group(path: str) -> str:
    """Return the name of the group that may use a port."""
    import grp

    try:
        return grp.getgrgid(Path(path).stat().st_gid).gr_name
    except (OSError, KeyError):
        return "dialout"
