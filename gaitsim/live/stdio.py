"""Standard input and output kept for commands and snapshots, whatever a plugin prints."""

import os
from collections.abc import Iterator


class Wire:
    """A stream of bytes to a descriptor; a line goes out whole.

    Args:
        descriptor: of a pipe or file.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def write(self, data: bytes) -> None:
        """Write all of it, waiting for a slow reader.

        Raises:
            OSError: there is no reader any more.
        """
        view = memoryview(data)
        while view:
            view = view[os.write(self._descriptor, view) :]


def lines(descriptor: int) -> Iterator[bytes]:
    """Whole lines, as they come."""
    rest = b""
    while data := os.read(descriptor, 65536):
        *whole, rest = (rest + data).split(b"\n")
        yield from whole


def isolate_stdio() -> tuple[int, Wire]:
    """Keep standard input and output to ourselves.

    Everything else in this process, and worker processes, print to standard error and read
    nothing.

    Returns:
        A descriptor to read commands from, and a wire to write snapshots to.
    """
    commands, snapshots = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return commands, Wire(snapshots)
