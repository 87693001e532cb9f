"""`gaitsim study`."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.run import Dask, Workers


def study(
    study: Annotated[
        str,
        typer.Argument(
            help="A ready study, the path of a TOML file, or the folder of a study to go on with.",
            metavar="NAME|FILE|FOLDER",
        ),
    ],
    workers: Workers = None,
    dask: Dask = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the study. Default: studies/<name>.")
    ] = None,
) -> None:
    """Sweep options over all cores; results in one table, with surfaces and a summary.

    Ctrl-C stops; the finished cells are kept, and the folder's name goes on with the rest.

    [bold]Examples[/bold]

    gaitsim study millipede-operators

    gaitsim study my-study.toml --out studies/mine

    gaitsim study studies/mine

    gaitsim study millipede-operators --dask tcp://host:8786
    """
    from gaitsim.cli.actions.study import run_study

    run_study(study, out, workers, dask)
