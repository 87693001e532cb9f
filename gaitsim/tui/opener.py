"""Open or download written files, or copy their paths."""

import asyncio
import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from textual.app import App

# The formats of data and pictures that gaitsim writes; no others, such as programs, are opened.
OPENED = frozenset(
    f".{name}"
    for name in (
        "csv",
        "gif",
        "html",
        "json",
        "mat",
        "mp4",
        "npz",
        "pdf",
        "png",
        "svg",
        "toml",
        "txt",
    )
)
ACTIVE = frozenset({".html", ".svg"})
"""Formats that may contain scripts; opened only if a task of this app wrote the file."""
PATIENCE = 3.0  # seconds after which a running opener is assumed to show the file


def opener() -> Sequence[str]:
    """Return the command that opens files; () without one, such as over SSH."""
    if sys.platform == "darwin":
        return ("open",)
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    found = shutil.which("xdg-open") if shown else None
    return (found,) if found else ()


async def open_file(file: Path) -> bool:
    """Open a file; return whether a program accepted it."""
    command = opener()
    if not command or file.suffix.lower() not in OPENED or not file.is_file():
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


async def hand_over(app: App[Any], file: Path, *, made: bool = False) -> None:
    """Open a file; without a program for it, copy its path.

    In a browser, download the file, or open a page in another tab, isolated from the app.

    Args:
        app: app that opens the file.
        file: file to open.
        made: whether a task of this app wrote it. Runs of others may contain untrusted pages.
    """
    if not file.is_file():
        app.notify(f"file not found: {file}", severity="error", markup=False)
    elif app.is_web:
        show = getattr(app._driver, "show_page", None) if file.suffix == ".html" else None
        download(app, [file]) if show is None else show(file)
    elif file.suffix.lower() in ACTIVE and not made:
        copy_paths(app, [file], "Not opened, as it may contain scripts of others; path copied")
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
