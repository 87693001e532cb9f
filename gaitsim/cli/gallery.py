"""`gaitsim gallery`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.runs import check_root
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, report_files
from gaitsim.console.progress_bar import Progress


def gallery(
    root: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder that holds the runs.")
    ] = Path("runs"),
    out: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER", help="Folder of the website; an existing website of runs is replaced."
        ),
    ] = Path("site"),
) -> None:
    """Create a website from a folder of runs, with a page for each run that plays its champion.

    Within each body and fitness, the best run comes first. The site needs no server: open its
    index.html, or copy the folder to any web server.

    [bold]Examples[/bold]

    gaitsim gallery

    gaitsim gallery runs/ --out site/
    """
    from gaitsim.render.gallery import write_gallery

    check_root(root)
    try:
        with interruptible(), Progress("gallery", "runs") as progress:
            site = write_gallery(root, out, begin=progress.expect, advance=progress.advance)
    except KeyboardInterrupt:
        notice(f"Stopped; {out} contains the runs that were finished.")
        sys.exit(INTERRUPTED)
    report_files(site.index)
    for name, reason in site.problems:
        notice(f"{name}: {reason}")
    echo(f"{site.index}: {site.shown} run{'s' * (site.shown != 1)}")
