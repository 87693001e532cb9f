"""Handling of Ctrl-C and SIGTERM: stop at once, or after the current generation."""

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import notice


class Interrupts:
    """A handler of SIGINT and SIGTERM that raises KeyboardInterrupt, or defers it.

    Attributes:
        deferred: whether the first signal only sets `requested`; the second one raises.
        requested: whether the user asked to stop.
        on_request: callback for the first, deferred signal.
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
    def deferring(self, on_request: Callable[[], None]) -> Iterator[None]:
        """Defer the first signal during the block, and call `on_request` instead."""
        self.deferred, self.on_request = True, on_request
        try:
            yield
        finally:
            self.deferred = False


@contextmanager
def interruptible() -> Iterator[Interrupts]:
    """Handle SIGINT and SIGTERM in the block, even in a background job of a script."""
    handler = Interrupts()
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield handler
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def all_or_nothing() -> Iterator[None]:
    """Exit when the user stops the block, which must have written nothing by then."""
    try:
        with interruptible():
            yield
    except KeyboardInterrupt:
        notice("Stopped; nothing was written.")
        sys.exit(INTERRUPTED)
