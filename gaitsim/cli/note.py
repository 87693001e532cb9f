"""`gaitsim note`."""

from typing import Annotated

import typer

from gaitsim.cli.options import Json, RunName
from gaitsim.console.printing import echo, notice, print_json
from gaitsim.runs.files.folder import find_run
from gaitsim.runs.manage import read_note, write_note


def note(
    run: RunName,
    text: Annotated[
        str | None,
        typer.Argument(
            metavar="TEXT",
            help="Text of the new note; '' removes the note. Default: print the note.",
            show_default=False,
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Show or write the note of a run.

    A note is free text, stored in the run's folder.

    [bold]Examples[/bold]

    gaitsim note spider "Straight, but it drags its left hind leg."

    gaitsim note spider
    """
    path = find_run(run)
    if text is not None:
        write_note(path, text)
    found = read_note(path)
    if json:
        print_json({"run": str(path), "note": found})
    elif text is not None:
        echo(f"{path}: note {'saved' if found else 'removed'}")
    elif found:
        echo(found)
    else:
        notice(f"{path} has no note.")
