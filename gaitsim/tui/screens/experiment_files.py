"""Ask for the path of an experiment file to save or load."""

import asyncio
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.questions import Ask, Confirm


async def ask_save(screen: GaitScreen, name: str, toml: str) -> bool:
    """Ask where to save an experiment; return whether it was saved. Await it in a worker."""
    ask = Ask("Save the experiment file as", f"{name}.toml", about="The file lists every option.")
    answer = await screen.app.push_screen_wait(ask)
    if answer is None:
        return False
    path = Path(answer if answer.endswith(".toml") else f"{answer}.toml").expanduser()
    question = Confirm(f"Replace {path}?", "Replace", "The file exists.", danger=True)
    if path.exists() and not await screen.app.push_screen_wait(question):
        return False
    try:
        await asyncio.to_thread(write_bytes, path, toml.encode())
    except GaitsimError as error:
        screen.gaitsim.show_error(error)
        return False
    screen.notify(f"{path}\n$ gaitsim run {path}", title="Saved", markup=False)
    return True


async def ask_load(screen: GaitScreen) -> str | None:
    """Ask for the file of an experiment or a robot; return its path, or None."""
    ask = Ask("Load the file", "./", about="The TOML file of an experiment or a robot.")
    answer = await screen.app.push_screen_wait(ask)
    if answer is None:
        return None
    path = Path(answer).expanduser()
    # A path with a folder is not mistaken for a preset's name.
    return str(path) if path.name != str(path) else f"./{path}"
