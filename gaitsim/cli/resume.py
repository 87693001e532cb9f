"""`gaitsim resume`."""

from typing import Annotated

import typer

from gaitsim.cli.cluster import cluster
from gaitsim.cli.evolving import evolve_run
from gaitsim.cli.options import Dask, Json, RunName, Set, Workers
from gaitsim.experiment import parse_assignments
from gaitsim.runs.files.folder import find_run


def resume(
    run: RunName,
    generations: Annotated[
        int | None, typer.Option(help="Go on to this generation. Default: as far as planned.")
    ] = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    any_version: Annotated[
        bool,
        typer.Option(
            "--any-version", help="Go on although a plugin's package has another version now."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Go on with a run, exactly as if it had never stopped; or train it on under other options.

    What --set changes holds from the next generation on: a new stage of the run.

    [bold]Examples[/bold]

    gaitsim resume spider

    gaitsim resume spider --generations 2000

    gaitsim resume spider --set mutation.rate=0.01 --generations 400

    gaitsim resume spider --set fitness.plugin=spider-classic --generations 400
    """
    path, overrides = find_run(run), parse_assignments(set_ or ())
    with cluster(dask, workers) as executor:
        evolve_run(
            path,
            workers=workers,
            json=json,
            cluster=executor,
            overrides=overrides,
            generations=generations,
            any_version=any_version,
        )
