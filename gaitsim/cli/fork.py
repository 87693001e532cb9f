"""`gaitsim fork`."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.options import Json, RunName, Set
from gaitsim.console.printing import echo, notice, print_json
from gaitsim.runs.files.folder import command, find_run


def fork(
    run: RunName,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder of the copy. Default: the run's folder name with a number.",
        ),
    ] = None,
    set_: Set = None,
    generations: Annotated[
        int | None,
        typer.Option(
            help="Continue the copy up to this generation. Default: the number originally planned."
        ),
    ] = None,
    any_version: Annotated[
        bool,
        typer.Option("--any-version", help="Copy even if a plugin's package has changed version."),
    ] = False,
    json: Json = False,
) -> None:
    """Copy a run, for example to continue the copy with changed options.

    The copy has the run's last generation, history and champions, so it continues from the last
    generation. Use 'gaitsim run --from RUN@N' to start a new run from the best individual of an
    earlier generation, whose whole population is not stored. The original is not changed, and may
    be evolving during the copy.

    [bold]Examples[/bold]

    gaitsim fork spider

    gaitsim fork spider --out runs/bold --set mutation.rate=0.2 --generations 1500
    """
    from gaitsim.experiment import parse_assignments
    from gaitsim.runs.creation import fork_run
    from gaitsim.runs.snapshot import RunSnapshot

    source = find_run(run)
    changes = parse_assignments(set_ or ())
    path = fork_run(source, out, changes, generations=generations, any_version=any_version)
    generation = RunSnapshot(path).generation
    if json:
        print_json({"run": str(path), "of": str(source), "generation": generation})
        return
    echo(f"{path}: a copy of {source} at generation {generation}")
    notice(f"Continue with: {command('resume', path)}")
