"""`gaitsim plot`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gaitsim.choices import PlotFormat, PlotKind, Theme
from gaitsim.cli.options import BestOf, Damage, MemberOf, RunName, World
from gaitsim.console.printing import status

Kind = Literal[PlotKind, "all"]


def plot(
    run: RunName,
    kind: Annotated[
        Kind,
        typer.Option(
            metavar="KIND",
            help="Kind of plot:\n\n"
            "of the evolution: fitness, terms, diversity, genome, runs, search\n\n"
            "of a front or an archive: front, archive, gaits\n\n"
            "of the motion: path, channel, footfall, phase, joints, stability\n\n"
            "all: every kind that the run has data for",
        ),
    ] = "fitness",
    generation: BestOf = None,
    member: MemberOf = None,
    damage: Damage = None,
    world: World = None,
    generations: Annotated[
        str | None,
        typer.Option(
            metavar="N,N,…",
            help="For --kind channel: plot the best individuals of several generations, such as "
            "1,50,300.",
        ),
    ] = None,
    channel: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Channel of the motion to plot, such as 'altitude'; an unknown name lists all "
            "channels. For --kind channel; for --kind joints, a channel of joints "
            "such as 'torque'.",
        ),
    ] = None,
    component: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Component of the channel, such as z, 3 or 'L1 coxa'; may be repeated. "
            "Default: all components.",
        ),
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            metavar="START:END", help="Part of the motion to plot, in seconds, such as 2:5."
        ),
    ] = None,
    beside: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RUN",
            help="For --kind runs: also plot this run and its repeats, the runs in the same folder "
            "that differ only in the seed; may be repeated.",
        ),
    ] = None,
    axes: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="NAME NAME",
            help="For --kind archive: two axes of the archive. Default: all pairs of axes.",
        ),
    ] = None,
    theme: Annotated[Theme, typer.Option(help="Colour theme.")] = "light",
    format: Annotated[
        PlotFormat | None,
        typer.Option(
            help="Format of the figure. Default: from the extension of --out, otherwise 'png'."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|FOLDER",
            help="File to write; for --kind all, a folder, created if missing. Default: in the "
            "run's exports folder.",
        ),
    ] = None,
) -> None:
    """Plot a run, or the motion of its champion, at the width of a journal column.

    [bold]Examples[/bold]

    gaitsim plot spider --kind fitness --out fitness.pdf

    gaitsim plot spider --kind footfall --window 4:7

    gaitsim plot spider --kind footfall --damage "L2 lost"

    gaitsim plot walker --kind footfall --world "friction 0.4"

    gaitsim plot quadruped --kind joints --channel torque

    gaitsim plot spider --kind runs --beside spider-2

    gaitsim plot spider-atlas --kind archive

    gaitsim plot spider-atlas --kind gaits

    gaitsim plot fly --kind channel --channel altitude --generations 1,50,200

    gaitsim plot spider --kind all --format svg --theme dark
    """
    with status("Reading the run …"):
        # These imports take most of the start-up time.
        from gaitsim.cli.parsing import parse_body_changes, parse_individuals, parse_window
        from gaitsim.cli.plotting import check_options, plot_all, plot_one
        from gaitsim.render.plots.request import Request
        from gaitsim.render.plots.style import THEMES
        from gaitsim.runs.files.folder import find_run
        from gaitsim.runs.snapshot import RunSnapshot

        numbers = parse_individuals(generation, generations, member)
        check_options(
            kind,
            {
                "--generation": generation,
                "--member": member,
                "--damage": damage,
                "--world": world,
                "--generations": generations,
                "--channel": channel,
                "--component": component,
                "--window": window,
                "--beside": beside,
                "--axes": axes,
            },
        )
        request = Request(
            run=RunSnapshot(find_run(run)),
            channel=channel,
            components=tuple(component or ()),
            window=parse_window(window),
            theme=THEMES[theme],
            beside=tuple(RunSnapshot(find_run(one)) for one in beside or ()),
            axes=axes or (),
        )
        changed = parse_body_changes(damage, world)
    if kind == "all":
        plot_all(request, numbers, changed, out, format or "png")
    else:
        plot_one(kind, request, numbers, changed, out, format)
