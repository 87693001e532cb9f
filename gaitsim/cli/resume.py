"""`gaitsim resume`."""

from typing import Annotated

import typer

from gaitsim.cli.options import Dask, Detach, Json, RunName, Set, Workers
from gaitsim.runs.files.folder import find_run


def resume(
    run: RunName,
    generations: Annotated[
        int | None,
        typer.Option(
            help="Continue up to this generation. Default: the number originally planned."
        ),
    ] = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    any_version: Annotated[
        bool,
        typer.Option(
            "--any-version", help="Continue even if a plugin's package has changed version."
        ),
    ] = False,
    detach: Detach = False,
    json: Json = False,
) -> None:
    """Continue a run exactly as if it had never stopped, optionally with changed options.

    Changes made with --set start a new stage of the run at the next generation.

    [bold]Examples[/bold]

    gaitsim resume spider

    gaitsim resume spider --generations 1500

    gaitsim resume spider --set mutation.rate=0.01 --generations 2000

    gaitsim resume spider --set fitness.plugin=spider-classic --generations 2500

    gaitsim resume spider --detach
    """
    from gaitsim.cli.evolving import chosen_place, evolve_run
    from gaitsim.experiment import parse_assignments
    from gaitsim.runs.snapshot import RunSnapshot

    found, overrides = RunSnapshot(find_run(run)), parse_assignments(set_ or ())
    with chosen_place(dask, workers, detach=detach) as place:
        evolve_run(
            found,
            place,
            workers=workers,
            json=json,
            overrides=overrides,
            generations=generations,
            any_version=any_version,
        )
