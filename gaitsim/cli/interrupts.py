"""Ctrl-C and SIGTERM: at once, or after the current generation."""

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from gaitsim.cli import INTERRUPTED
from gaitsim.cli.console import notice


class Interrupts:
    """A handler of SIGINT and SIGTERM that raises KeyboardInterrupt unless told to defer it.

    Attributes:
        deferred: whether the first signal only sets `requested`; the second one raises.
        requested: whether the user asked to stop.
        on_request: called when the first signal is deferred.
    """

    def __init__(self) -> None:
        self.deferred = self.requested = False
        self.on_request: Callable[[], None] = lambda: None

    def __call__(self, _signal: int, _frame: FrameType | None) -> None:
        if self.requested or not self.deferred:
            raise KeyboardInterrupt
        self.requested = True
        with suppress(OSError, RuntimeError):  # the stream may be in use, or closed
            self.on_request()


@contextmanager
def interruptible() -> Iterator[Interrupts]:
    """Handle SIGINT and SIGTERM in the block, also in the background of a script."""
    handler = Interrupts()
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield handler
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def all_or_nothing(remedy: str = "") -> Iterator[None]:
    """End the program when the user stops the block, which then has written nothing.

    Args:
        remedy: a sentence on how to begin again.
    """
    try:
        with interruptible():
            yield
    except KeyboardInterrupt:
        notice(f"Stopped; nothing was written. {remedy}".rstrip())
        sys.exit(INTERRUPTED)
