"""Open or download exported files, or copy their paths."""

import asyncio
import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from textual.app import App

# The formats that gaitsim writes. Other files, such as programs, are not opened.
OPENABLE = frozenset({".csv", ".json", ".mat", ".npz", ".toml", ".txt"}) | frozenset(
    {".gif", ".html", ".mp4", ".pdf", ".png", ".svg"}
)
ACTIVE = frozenset({".html", ".svg"})
"""Formats that may contain scripts; opened only if a task of this app wrote the file."""
PATIENCE = 3.0  # seconds after which a program that still runs counts as successful


def opener() -> Sequence[str]:
    """Return the command that opens files; () if there is none, such as over SSH."""
    if sys.platform == "darwin":
        return ("open",)
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    found = shutil.which("xdg-open") if shown else None
    return (found,) if found else ()


async def open_file(file: Path) -> bool:
    """Open a file; return whether a program accepted it."""
    command = opener()
    if not command or file.suffix.lower() not in OPENABLE or not file.is_file():
        return False
    nothing = asyncio.subprocess.DEVNULL
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            str(file.absolute()),
            stdin=nothing,
            stdout=nothing,
            stderr=nothing,
            start_new_session=True,
        )
        return await asyncio.wait_for(process.wait(), PATIENCE) == 0
    except TimeoutError:
        return True
    except OSError:
        return False


async def open_or_copy(app: App[Any], file: Path, *, trusted: bool = False) -> None:
    """Open a file, or copy its path if no program opens it.

    In a browser, download the file; open a page in another tab, isolated from the app.

    Args:
        app: app that opens the file.
        file: file to open.
        trusted: whether a task of this app wrote the file. Pages in the runs of other people may
            contain scripts.
    """
    if not file.is_file():
        app.notify(f"file not found: {file}", severity="error", markup=False)
    elif app.is_web:
        show = getattr(app._driver, "show_page", None) if file.suffix == ".html" else None
        download(app, [file]) if show is None else show(file)
    elif file.suffix.lower() in ACTIVE and not trusted:
        copy_paths(app, [file], "Not opened, because it may contain untrusted scripts; path copied")
    elif await open_file(file):
        app.notify(str(file), title="Opened", markup=False)
    else:
        copy_paths(app, [file], "No program to open the file; path copied")


def copy_paths(app: App[Any], files: Sequence[Path], title: str = "Copied") -> None:
    """Copy the paths of files, one per line."""
    text = "\n".join(str(file.absolute()) for file in files)
    app.copy_to_clipboard(text)
    app.notify(text, title=title, markup=False)


def download(app: App[Any], files: Sequence[Path]) -> None:
    """Send files to the browser."""
    try:
        for file in files:
            app.deliver_binary(file, open_method="download")
    except OSError as error:
        app.notify(str(error.strerror), severity="error", markup=False)
