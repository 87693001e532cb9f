"""`gaitsim rename`."""

from typing import Annotated

import typer

from gaitsim.cli.options import Json, RunName
from gaitsim.console.printing import echo, print_json
from gaitsim.runs.files.folder import find_run
from gaitsim.runs.manage import rename_run


def rename(
    run: RunName,
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="New name of the run's folder.", show_default=False),
    ],
    json: Json = False,
) -> None:
    """Rename a run.

    The run's folder gets a new name in the same place. A run cannot be renamed while it is
    evolving.

    [bold]Examples[/bold]

    gaitsim rename spider-2 bold
    """
    before = find_run(run)
    after = rename_run(before, name)
    if json:
        print_json({"run": str(after), "was": str(before)})
    else:
        echo(f"{before} is now {after}")
