"""`gaitsim tui`."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.tui.app import GaitsimApp


Root = Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder that holds the runs.")]
ThemeName = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Name of a theme, such as 'gaitsim-light'."),
]


def tui(root: Root = Path("runs"), theme: ThemeName = None) -> None:
    """Open the terminal UI: list, start, watch, replay and compare runs.

    [bold]Examples[/bold]

    gaitsim tui

    gaitsim tui experiments/spring --theme gaitsim-okabe-ito
    """
    from gaitsim.tui.app import GaitsimApp
    from gaitsim.tui.config import config_path, read_config
    from gaitsim.tui.themes import check_theme

    check_terminal("use 'gaitsim runs' and 'gaitsim run' instead; see 'gaitsim --help'")
    chosen = check_theme(theme, where="--theme") if theme else None
    run_app(GaitsimApp(root, config=read_config(config_path()), theme=chosen))


tui.keeps_stdout = True  # type: ignore[attr-defined]


def check_terminal(remedy: str) -> None:
    """Check that standard input and output are a terminal.

    Args:
        remedy: alternative without a terminal, for the message.
    """
    # `gaitsim serve` sets a driver of Textual instead of a terminal.
    if not (os.environ.get("TEXTUAL_DRIVER") or (sys.stdin.isatty() and sys.stdout.isatty())):
        raise GaitsimError(
            "the terminal UI needs a terminal as its input and output", remedy=remedy
        )


def run_app(app: GaitsimApp) -> None:
    """Run the app; exit with its exit code if it fails."""
    app.run()
    if app.return_code:
        sys.exit(app.return_code)
