"""Standard input and output, reserved for commands and snapshots."""

import os
from collections.abc import Iterator


def write_all(descriptor: int, data: bytes) -> None:
    """Write all bytes, waiting for a slow reader."""
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


def lines(descriptor: int) -> Iterator[bytes]:
    """Yield whole lines as they arrive."""
    rest = b""
    while data := os.read(descriptor, 65536):
        *whole, rest = (rest + data).split(b"\n")
        yield from whole


def isolate_stdio() -> tuple[int, int]:
    """Return new descriptors of standard input and output that nothing else uses.

    All other code in this process, such as plugins, and in worker processes prints to standard
    error and reads nothing.
    """
    commands, snapshots = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return commands, snapshots
