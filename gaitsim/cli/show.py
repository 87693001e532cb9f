"""`gaitsim show`."""

from typing import Annotated

import typer

from gaitsim.cli.options import Json, RunName
from gaitsim.console.printing import echo, notice, print_json
from gaitsim.runs.files.folder import find_run


def show(
    run: RunName,
    fingerprint: Annotated[
        bool,
        typer.Option(
            "--fingerprint",
            help="Print only the fingerprint: a SHA-256 hash of all results except times, so that "
            "equal fingerprints mean equal runs.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Show a run in full: its plugins, progress, stages and champion.

    A stage is a span of generations with the same options; changing an option of a run starts the
    next stage.

    [bold]Examples[/bold]

    gaitsim show spider

    gaitsim show spider --fingerprint
    """
    from gaitsim.cli.run_view import print_run, print_run_as_json
    from gaitsim.runs.snapshot import RunSnapshot

    opened = RunSnapshot(find_run(run))
    if opened.warning:
        notice(f"Warning: {opened.warning}")
    if fingerprint and json:
        print_json({"run": str(opened.path), "fingerprint": opened.fingerprint()})
    elif fingerprint:
        echo(opened.fingerprint())
    elif json:
        print_run_as_json(opened)
    else:
        print_run(opened)
