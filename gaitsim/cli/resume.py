"""`gaitsim resume`."""

from typing import Annotated

import typer

from gaitsim.cli.run import Json, Workers


def resume(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    generations: Annotated[
        int | None, typer.Option(help="Go on to this generation. Default: as far as planned.")
    ] = None,
    workers: Workers = None,
    any_version: Annotated[
        bool,
        typer.Option(
            "--any-version", help="Go on although a plugin's package has another version now."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Go on with a run, exactly as if it had never stopped.

    [bold]Examples[/bold]

    gaitsim resume spider

    gaitsim resume spider --generations 2000
    """
    from gaitsim.cli.evolving import evolve_run
    from gaitsim.runs.folder import find_run

    evolve_run(
        find_run(run),
        workers=workers,
        json=json,
        generations=generations,
        any_version=any_version,
    )
