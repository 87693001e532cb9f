"""The interface of displays that follow an evolving run."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from gaitsim.console.printing import notice
from gaitsim.live.protocol import Snapshot

Row = Mapping[str, Any]
"""A row of the history: one generation."""

BEST_SHOWN = 5  # individuals
# Messages for the states in which no generation is being evolved.
RESTING = {
    "preparing": "Preparing: the first run of a body compiles its kernels …",
    "queued": "Queued: starts when an earlier run ends.",
    "paused": "Paused.",
}
STOPPING = "Stopping after this generation; press Ctrl-C again to stop at once."


class Display:
    """A context manager that follows a run; entering and leaving do nothing by default.

    Args:
        path: folder of the run.
        known: current state of the run, with all rows of its history.
    """

    def __init__(self, path: Path, known: Snapshot) -> None:
        self._path, self._snapshot = path, known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Report that a stage starts.

        Args:
            number: number of the stage, counted from 1.
            first: first generation of the stage.
            changes: descriptions of the changed options.
            rescored: the last generation and its row, re-evaluated; None if the stage keeps the
                scores.
        """

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Show the state of the run and its newly finished generations."""

    def warn(self, text: str) -> None:
        """Show a lasting message."""
        notice(text)

    def stopping(self) -> None:
        """Report that the run stops after this generation; called by a signal handler."""
        notice(STOPPING)


def stage_line(number: int, first: int, changes: Sequence[str]) -> str:
    return f"stage {number}, from generation {first}: {'; '.join(changes)}"
