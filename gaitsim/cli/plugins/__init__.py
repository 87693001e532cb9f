"""`gaitsim plugins`."""

from collections.abc import Mapping
from typing import ClassVar

import typer

from gaitsim.cli.help import LazyGroup


class _Commands(LazyGroup):
    package = __name__
    lines: ClassVar[Mapping[str, str]] = {
        "list": "List all plugins by kind, with the package of each. Imports none of them.",
        "show": "Show a plugin's options: default, what is allowed, unit, meaning.",
        "check": "Check whether plugins keep their contract, and say what to mend.",
        "new": "Write the package of a new plugin, which works as it is, into the folder NAME.",
    }


app = typer.Typer(cls=_Commands, no_args_is_help=True, add_completion=False)


@app.callback()
def plugins() -> None:
    """Installed bodies and operators, and new ones."""
