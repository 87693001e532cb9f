"""What a display of a run that evolves must do."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from gaitsim.cli.console import notice
from gaitsim.live.protocol import Snapshot

Row = Mapping[str, Any]
"""A generation's row of the history."""

BEST_SHOWN = 5
RESTING = {
    "preparing": "Preparing: the first run of a body compiles its kernels …",
    "queued": "Queued: it evolves when one of the runs before it ends.",
    "paused": "Paused.",
}
STOPPING = "Stopping after this generation; again to stop at once."


class Display:
    """A context manager that follows a run; by default there is nothing to begin or end.

    Args:
        path: the run's folder.
        known: the run as it is, with all rows of its history.
    """

    def __init__(self, path: Path, known: Snapshot) -> None:
        self._path, self._snapshot = path, known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def begin_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Report that a stage begins.

        Args:
            number: from 1.
            first: its first generation.
            changes: what it changes.
            rescored: the last generation and its row under other scores; None where the stage
                keeps the scores.
        """

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Show the state of a run, and the generations that were finished."""

    def warn(self, text: str) -> None:
        """Show a message that stays."""
        notice(text)

    def stopping(self) -> None:
        """Report that the run stops after this generation; called by a signal's handler."""
        notice(STOPPING)


def stage_line(number: int, first: int, changes: Sequence[str]) -> str:
    return f"stage {number} from generation {first} on: {'; '.join(changes)}"
