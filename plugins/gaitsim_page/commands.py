"""`gaitsim gallery` and `gaitsim steer`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.actions.runs import check_root
from gaitsim.choices import STEERING_PRESET
from gaitsim.cli.completion import preset_names
from gaitsim.cli.tui import check_terminal, run_app
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, report_files
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.runs.files.folder import command

ALLOWED = "COMMAND=RUN, COMMAND=RUN@GENERATION or COMMAND=FILE of a champion"


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
    from gaitsim_page.gallery import write_gallery

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


def steer(
    experiment: Annotated[
        str,
        typer.Argument(
            help="Name of a preset or path of an experiment file whose body can be steered.",
            metavar="NAME|FILE",
            autocompletion=preset_names,
            show_default=True,
        ),
    ] = STEERING_PRESET,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COMMAND=RUN[@N]|FILE",
            help="While this steering command is active, control the body with the champion of a "
            "run, the best individual of its generation N, or a champion file; may be repeated.",
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Set an option of the experiment, such as mutation.rate=0.1; may be repeated.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.html",
            help="Write a web page (one file) in which the body can be steered, instead of opening "
            "the terminal UI.",
        ),
    ] = None,
) -> None:
    """Fly a body with the keyboard: each key puts another trained network in control.

    The keys select steering commands, such as climb or left. Each command has its own network.

    [bold]Examples[/bold]

    gaitsim steer

    gaitsim steer fly-steer-hover --controller climb=runs/fly-steer-climb

    gaitsim steer --out fly.html
    """
    from gaitsim.experiment import load_experiment, parse_assignments
    from gaitsim.steering import Drive, controllers_of

    if out is None:
        check_terminal("write a web page instead: gaitsim steer --out fly.html")
    loaded = load_experiment(experiment, parse_assignments(set_ or ()))
    replaced = dict(map(_parse_controller, controller or ()))
    controllers = controllers_of(loaded, replaced)
    if out is not None:
        from gaitsim_page.steering import write_page

        description = write_page(loaded, controllers, out)
        report_files(out)
        echo(f"{out}: {description}")
        return
    from gaitsim.tui.app import GaitsimApp
    from gaitsim.tui.config import config_path, read_config
    from gaitsim.tui.screens.steering import Steering

    options = [part for text in controller or () for part in ("--controller", text)]
    options += [part for text in set_ or () for part in ("--set", text)]
    line = command("steer", *([] if experiment == STEERING_PRESET else [experiment]), *options)
    drive = Drive(loaded, controllers)
    run_app(
        GaitsimApp(config=read_config(config_path()), first=lambda: Steering(lambda: drive, line))
    )


def _parse_controller(text: str) -> tuple[str, str]:
    """Return the command and the individual in a value of `--controller`."""
    name, equals, reference = text.partition("=")
    if not (name and equals and reference):
        raise GaitsimError(f"invalid controller: {text!r}", where="--controller", allowed=ALLOWED)
    return name, reference
