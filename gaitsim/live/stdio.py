"""Standard input and output kept for commands and snapshots, whatever a plugin prints."""

import os
from collections.abc import Iterator


def write_all(descriptor: int, data: bytes) -> None:
    """Write all bytes, waiting for a slow reader.

    Raises:
        OSError: the reader has gone.
    """
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
    """Return new descriptors of standard input and output, for us alone.

    Everything else in this process, and worker processes, print to standard error and read
    nothing.
    """
    commands, snapshots = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return commands, snapshots
