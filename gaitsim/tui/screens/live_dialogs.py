"""The questions of the live screen: which options change, and how many generations to evolve."""

from pathlib import Path

from textual.app import App

from gaitsim.errors import RunError
from gaitsim.experiment import Overrides
from gaitsim.live.protocol import Snapshot
from gaitsim.tui.screens.change_dialog import ChangeDialog, ChangeRequest
from gaitsim.tui.screens.questions import Ask

MOST_GENERATIONS = 100_000_000


async def ask_changes(
    app: App[object], run: Path, snapshot: Snapshot, *, fork: bool = False
) -> ChangeRequest | None:
    """Ask which options change from the next generation on; None changes nothing.

    Args:
        app: shows the dialog.
        run: the run's folder.
        snapshot: the latest of the run.
        fork: whether they change in a copy of the run.
    """
    # A stage needs a generation, so a finished run needs more of them.
    typed = f"evolution.generations={_further(snapshot)} " if snapshot.state == "finished" else ""
    return await app.push_screen_wait(ChangeDialog(run, fork=fork, typed=typed))


async def ask_generations(app: App[object], snapshot: Snapshot) -> Overrides | None:
    """Ask how many generations a run is to have; None to leave it as it is."""
    done = snapshot.generation

    def check(text: str) -> None:
        number = int(text) if text.isascii() and text.isdecimal() and len(text) < 10 else 0
        if not done < number <= MOST_GENERATIONS:
            raise RunError(
                f"invalid number of generations: {text!r}",
                allowed=f"{done + 1:,} to {MOST_GENERATIONS:,}",
            )

    about = f"It is at generation {done:,}."
    question = Ask(
        "How many generations is the run to have?", str(_further(snapshot)), check, about
    )
    answer = await app.push_screen_wait(question)
    return {"evolution.generations": int(answer)} if answer else None


def _further(snapshot: Snapshot) -> int:
    """Return one and a half times the generations of a run."""
    planned = max(snapshot.generations, snapshot.generation)
    return planned + max(1, planned // 2)
