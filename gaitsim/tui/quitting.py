"""What happens to runs in the background and to commands when the app ends."""

import asyncio
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from textual.app import App

from gaitsim.errors import GaitsimError
from gaitsim.tui.screens.questions import Choose, Confirm
from gaitsim.tui.tasks import Tasks

PATIENCE = 10.0  # seconds that a run gets to finish its generation
NAMES = 5  # of runs that are named


async def may_quit(app: App[None], drafts: Iterable[str], tasks: Tasks, folder: Path) -> bool:
    """Ask about what is not done, stop what is to be stopped, and return whether to quit.

    Args:
        app: asks.
        drafts: new runs that were changed, and neither begun nor saved.
        tasks: commands, which end with the app.
        folder: the folder of runs; those that evolve in the background may go on without the app.
    """
    if names := ", ".join(drafts):
        about = f"Changed and neither run nor saved: {names}"
        ask = Confirm("Discard the new run?", "Discard", about, danger=True)
        if not await app.push_screen_wait(ask):
            return False
    running = [task for task in tasks.all if task.running]
    if running:
        about = "\n".join(task.command for task in running)
        if not await app.push_screen_wait(Confirm("Stop what is being made?", "Stop", about)):
            return False
    evolving = await asyncio.to_thread(_evolving_in, folder)
    answer = await app.push_screen_wait(_question(evolving)) if evolving else "k"
    if answer is None:
        return False
    if running:
        await tasks.stop_all()
    if answer == "s":
        await asyncio.gather(*(asyncio.to_thread(_stop, run) for run in evolving))
    return True


def _question(runs: Sequence[Path]) -> Choose:
    names = ", ".join(run.name for run in runs[:NAMES]) + (", …" if len(runs) > NAMES else "")
    about = (
        "Runs that evolve on do so without the app: 'gaitsim runs' lists them, 'gaitsim stop RUN' "
        "stops one. Stopped runs are saved and can be resumed."
    )
    answers = {"k": "Keep evolving", "s": "Stop and save"}
    return Choose(f"Quit? In the background: {names}", answers, about)


def _evolving_in(folder: Path) -> list[Path]:
    """Return the runs of a folder that evolve in the background."""
    from gaitsim.runs.background import background_processes

    whole = folder.resolve()
    return [one.run for one in background_processes() if whole in one.run.parents]


def _stop(run: Path) -> None:
    """Stop a run; one whose generation takes longer stops after the app has ended."""
    from gaitsim.live.background import stop

    with suppress(GaitsimError):  # it has just ended
        stop(run, PATIENCE)
