"""Progress of a command: a bar on a terminal, JSON lines for programs, or lines in a log."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from gaitsim.console.printing import errors, notice, print_record
from gaitsim.console.streams import machine_readable

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

LINE_EVERY, RECORD_EVERY = 2.0, 0.1  # seconds between lines of a log, and between records


class Progress:
    """Report progress on standard error.

    Args:
        what: name of the work.
        unit: counted units, in the plural.
        total: total number of units; None while unknown.
        done: number of units already done.
        log: first line of a log, followed by a line every two seconds; '' for no log.
    """

    def __init__(
        self, what: str, unit: str, total: int | None = None, done: int = 0, *, log: str = ""
    ) -> None:
        self._what, self._unit, self._total, self._done = what, unit, total, done
        self._log = log
        self._bar: Bar | None = None
        self._reported = -LINE_EVERY

    def __enter__(self) -> Self:
        if not machine_readable() and errors().is_terminal:
            self._bar = _bar(self._unit)
            self._task = self._bar.add_task(self._what, total=self._total, completed=self._done)
            self._bar.start()
        elif machine_readable():
            self._report()
        elif self._log:
            notice(self._log)
            self._reported = time.monotonic()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def expect(self, total: int) -> None:
        """Set the total number of units."""
        self._total = total
        self._report()

    def advance(self, steps: int = 1) -> None:
        """Add to the number of units done."""
        self.reach(self._done + steps)

    def reach(self, done: int) -> None:
        """Set the number of units done."""
        self._done = done
        self._report()

    def _report(self) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=self._done, total=self._total)
            return
        if not (machine := machine_readable()) and not self._log:
            return
        now, every = time.monotonic(), RECORD_EVERY if machine else LINE_EVERY
        if now - self._reported < every and not (machine and self._done == self._total):
            return
        self._reported = now
        if machine:
            print_record(
                "progress", what=self._what, done=self._done, total=self._total, unit=self._unit
            )
        else:
            notice(f"{self._what}: {self._done}/{self._total} {self._unit}")


def _bar(unit: str) -> "Bar":
    from rich import progress

    return progress.Progress(
        progress.TextColumn("{task.description}", style="bold", markup=False),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TextColumn(f"{unit}, left"),
        progress.TimeRemainingColumn(),
        console=errors(),
        transient=True,
        # If redirected to a file, results would appear on the terminal instead.
        redirect_stdout=sys.stdout.isatty(),
    )
