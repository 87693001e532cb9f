"""`gaitsim plugins`."""

from collections.abc import Mapping
from typing import ClassVar

import typer

from gaitsim.cli.help import LazyGroup


class _Commands(LazyGroup):
    package = __name__
    lines: ClassVar[Mapping[str, str]] = {
        "list": "List all plugins by kind, with the package of each. Imports none of them.",
        "show": "Show a plugin's options: default, allowed values, unit, meaning.",
        "check": "Check whether plugins keep their contract, and report what to fix.",
        "new": "Create the package of a new plugin, ready to run, in the folder NAME.",
    }


app = typer.Typer(cls=_Commands, no_args_is_help=True, add_completion=False)


@app.callback()
def plugins() -> None:
    """List, show and check plugins, and create new ones."""
