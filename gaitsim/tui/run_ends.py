"""The ends of background runs, which the app reports on every screen."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.formatting import NOTIFIED, clip

if TYPE_CHECKING:
    from gaitsim.storage.background import BackgroundProcess

LONGEST = 200  # characters of a desktop notification


class RunEnd(NamedTuple):
    """The end of a background run.

    Attributes:
        title: name of the run, and how it ended.
        text: its result, or why it failed.
        failed: whether it failed.
    """

    title: str
    text: str
    failed: bool


class RunEnds:
    """The background runs of a folder, watched until they end.

    Args:
        folder: folder that holds the runs.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: set[Path] = set()

    def poll(self) -> list[RunEnd]:
        """Return the runs that have finished or failed since the last call.

        Runs that were stopped are left out.
        """
        found = {process.run for process in processes_in(self._folder)}
        ended, self._known = self._known - found, found
        return [end for run in sorted(ended) if (end := _end(run)) is not None]


def processes_in(folder: Path) -> "list[BackgroundProcess]":
    """Return the processes that evolve runs of a folder in the background."""
    from gaitsim.storage.background import background_processes

    whole = folder.resolve()
    return [process for process in background_processes() if whole in process.run.parents]


def desktop_notification(text: str) -> str:
    """Return the terminal's sequences for a bell and a desktop notification (OSC 9)."""
    text = "".join(char if char.isprintable() else " " for char in text[:LONGEST])
    return f"\x1b]9;gaitsim: {text}\x07\x07"


def _end(run: Path) -> RunEnd | None:
    """Return how a run ended; None if it was stopped, moved or deleted."""
    from gaitsim.storage.growing import overview

    found = overview(run)
    if found is None or found.state not in ("finished", "failed"):
        return None
    if found.failure is not None:
        text = clip(found.failure.what, NOTIFIED)
        return RunEnd(f"{visible(run.name)} failed", text, failed=True)
    best = "" if found.best is None else f", best {number(found.best, 4)}"
    text = f"generation {found.generation}{best}"
    return RunEnd(f"{visible(run.name)} finished", text, failed=False)
