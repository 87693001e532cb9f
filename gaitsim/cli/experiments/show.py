"""`gaitsim experiments show`."""

import io
import sys
from typing import Annotated

import typer


def show(
    name: Annotated[
        str,
        typer.Argument(help="A preset's name, or the path of a TOML file.", metavar="NAME|FILE"),
    ],
) -> None:
    """Print an experiment as TOML, with every option, to edit and run.

    [bold]Example[/bold]

    gaitsim experiments show spider > my-spider.toml

    gaitsim run my-spider.toml
    """
    from gaitsim.experiment import load_experiment

    text = load_experiment(name).to_toml()
    if isinstance(sys.stdout, io.TextIOWrapper) and not sys.stdout.isatty():
        # TOML is UTF-8 by definition, whatever the locale.
        sys.stdout.reconfigure(encoding="utf-8")
    print(text, end="")
