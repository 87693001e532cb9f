"""`gaitsim experiments`."""

from typing import Annotated

import typer

from gaitsim.cli.help import Command, Group

app = typer.Typer(
    name="experiments", cls=Group, help="The ready experiments.", no_args_is_help=True
)


@app.command("list", cls=Command)
def list_() -> None:
    """List the ready experiments of all installed packages."""
    from gaitsim.cli.console import output, table
    from gaitsim.registry import EXPERIMENTS, entries

    made = table("name", "what it is", "package")
    for name, claims in entries(EXPERIMENTS).items():
        made.add_row(name, _describe(name), " and ".join(claim.package for claim in claims))
    output().print(made, markup=False)


def _describe(name: str) -> str:
    from gaitsim.errors import GaitsimError
    from gaitsim.registry.presets import read_preset
    from gaitsim.render.terminal.text import visible
    from gaitsim.toml import parse

    try:
        return visible(str(parse(read_preset(name), f"preset {name}").get("description", "")))
    except GaitsimError as error:
        return visible(f"broken: {error.what}")


@app.command(cls=Command)
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
    import io
    import sys

    from gaitsim.experiment import load_experiment

    text = load_experiment(name).to_toml()
    if isinstance(sys.stdout, io.TextIOWrapper) and not sys.stdout.isatty():
        # TOML is UTF-8 by definition, whatever the locale.
        sys.stdout.reconfigure(encoding="utf-8")
    print(text, end="")
