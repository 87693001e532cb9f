"""`gaitsim experiments`."""

from collections.abc import Mapping
from typing import ClassVar

import typer

from gaitsim.cli.help import LazyGroup


class _Commands(LazyGroup):
    package = __name__
    lines: ClassVar[Mapping[str, str]] = {
        "list": "List the presets of all installed packages.",
        "show": "Print an experiment as TOML, with every option, to edit and run.",
    }


app = typer.Typer(cls=_Commands, no_args_is_help=True, add_completion=False)


@app.callback()
def experiments() -> None:
    """List and show presets."""
