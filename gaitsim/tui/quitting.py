"""Questions about drafts, tasks and runs in the background when the app quits."""

import asyncio
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from textual.app import App

from gaitsim.errors import GaitsimError
from gaitsim.tui.screens.questions import Choose, Confirm
from gaitsim.tui.tasks import Tasks

PATIENCE = 10.0  # seconds to wait for a run to finish its generation
NAMES = 5  # maximum number of runs to name


async def may_quit(app: App[None], drafts: Iterable[str], tasks: Tasks, folder: Path) -> bool:
    """Ask about unfinished work, stop tasks and runs as answered, and return whether to quit.

    Args:
        app: app that asks.
        drafts: names of changed new runs that were neither started nor saved.
        tasks: commands that end with the app.
        folder: folder of runs; those in the background may continue without the app.
    """
    if names := ", ".join(drafts):
        about = f"Not started and not saved: {names}"
        ask = Confirm("Discard the new run?", "Discard", about, danger=True)
        if not await app.push_screen_wait(ask):
            return False
    running = [task for task in tasks.all if task.running]
    if running:
        about = "\n".join(task.command for task in running)
        if not await app.push_screen_wait(Confirm("Stop the running tasks?", "Stop", about)):
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
        "Runs can continue without the app: 'gaitsim runs' lists them, 'gaitsim stop RUN' stops "
        "one. Stopped runs are saved and can be resumed."
    )
    answers = {"k": "Keep evolving", "s": "Stop and save"}
    return Choose(f"Quit? Runs in the background: {names}", answers, about)


def _evolving_in(folder: Path) -> list[Path]:
    """Return the runs of a folder that evolve in the background."""
    from gaitsim.runs.background import background_processes

    whole = folder.resolve()
    return [one.run for one in background_processes() if whole in one.run.parents]


def _stop(run: Path) -> None:
    """Stop a run; if its generation takes longer, it stops after the app has ended."""
    from gaitsim.live.process import stop

    with suppress(GaitsimError):  # it has just ended
        stop(run, PATIENCE)
