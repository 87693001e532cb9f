"""`gaitsim fork`."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.console import echo, notice, print_json
from gaitsim.cli.options import Json, RunName, Set
from gaitsim.experiment import parse_assignments
from gaitsim.runs.files.folder import command, find_run
from gaitsim.runs.fork import fork_run
from gaitsim.runs.snapshot import RunSnapshot


def fork(
    run: RunName,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the copy. Default: beside the run, with a number."),
    ] = None,
    set_: Set = None,
    generations: Annotated[
        int | None, typer.Option(help="How far the copy is to go. Default: as far as planned.")
    ] = None,
    any_version: Annotated[
        bool,
        typer.Option(
            "--any-version", help="Copy it although a plugin's package has another version now."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Copy a run, to let the copy go its own way under other options.

    The copy stands where the run stands: at its last generation, with its history and its
    champions. Only that generation's population is on the disk, so no earlier one can be
    copied; 'gaitsim run --from RUN@N' begins a new run with the best of an earlier one. The run
    itself stays as it is, and may be running meanwhile.

    [bold]Examples[/bold]

    gaitsim fork spider

    gaitsim fork spider --out runs/bold --set mutation.rate=0.2
    """
    source = find_run(run)
    changes = parse_assignments(set_ or ())
    path = fork_run(source, out, changes, generations=generations, any_version=any_version)
    generation = RunSnapshot(path).generation
    if json:
        print_json({"run": str(path), "of": str(source), "generation": generation})
        return
    echo(f"{path}: a copy of {source} at generation {generation}")
    notice(f"Go on with: {command('resume', path)}")
