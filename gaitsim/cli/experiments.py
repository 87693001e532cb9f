"""`gaitsim experiments`."""

from typing import Annotated

import typer

app = typer.Typer(name="experiments", help="The ready experiments.", no_args_is_help=True)


@app.command("list")
def list_() -> None:
    """List the ready experiments of all installed packages."""
    import tomllib

    from gaitsim.cli.console import output, table
    from gaitsim.errors import GaitsimError
    from gaitsim.presets import read_preset
    from gaitsim.registry import EXPERIMENTS, entries

    made = table("name", "what it is", "package")
    for name, claims in entries(EXPERIMENTS).items():
        try:
            description = str(tomllib.loads(read_preset(name)).get("description", ""))
        except (GaitsimError, tomllib.TOMLDecodeError) as error:
            description = f"broken: {error}"
        made.add_row(name, description, " and ".join(claim.package for claim in claims))
    output().print(made)


@app.command()
def show(
    name: Annotated[str, typer.Argument(help="A preset's name, or the path of a TOML file.")],
) -> None:
    """Print an experiment as TOML, with every option, to edit and run.

    [bold]Example[/bold]

    gaitsim experiments show spider > my-spider.toml; gaitsim run my-spider.toml
    """
    from gaitsim.experiment import load_experiment

    print(load_experiment(name).to_toml(), end="")
