"""Questions of the live screen: changes of options and the number of generations."""

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
    """Ask for options to change, starting with the next generation; return None for no change.

    Args:
        app: app that shows the dialog.
        run: folder of the run.
        snapshot: latest snapshot of the run.
        fork: whether to change them in a copy of the run.
    """
    # A stage has at least one generation, so a finished run needs more generations.
    typed = (
        f"evolution.generations={_suggested_generations(snapshot)} "
        if snapshot.state == "finished"
        else ""
    )
    return await app.push_screen_wait(ChangeDialog(run, fork=fork, typed=typed))


async def ask_generations(app: App[object], snapshot: Snapshot) -> Overrides | None:
    """Ask for the number of generations of a run; return None for no change."""
    done = snapshot.generation

    def check(text: str) -> None:
        number = int(text) if text.isascii() and text.isdecimal() and len(text) < 10 else 0
        if not done < number <= MOST_GENERATIONS:
            raise RunError(
                f"invalid number of generations: {text!r}",
                allowed=f"{done + 1:,} to {MOST_GENERATIONS:,}",
            )

    about = f"The run is at generation {done:,}."
    question = Ask("Evolve up to generation", str(_suggested_generations(snapshot)), check, about)
    answer = await app.push_screen_wait(question)
    return {"evolution.generations": int(answer)} if answer else None


def _suggested_generations(snapshot: Snapshot) -> int:
    """Return 1.5 times the generations of a run."""
    planned = max(snapshot.generations, snapshot.generation)
    return planned + max(1, planned // 2)
