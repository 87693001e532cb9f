"""`gaitsim plot`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

from gaitsim.choices import PlotFormat, PlotKind, Theme
from gaitsim.cli.console import echo, notice, report_files
from gaitsim.cli.options import BestOf, Damage, MemberOf, RunName, World
from gaitsim.cli.parsing import (
    BodyChange,
    choose_format,
    parse_body_changes,
    parse_individuals,
    parse_window,
)
from gaitsim.cli.progress_bar import Progress
from gaitsim.errors import GaitsimError, unsupported_flags
from gaitsim.individual import Choice
from gaitsim.render.plots.channel import KINDS_OF_CHANNELS, default_channel
from gaitsim.render.plots.kinds import ALL_OPTIONS, KINDS, file_stem
from gaitsim.render.plots.request import NothingToPlotError, Request
from gaitsim.render.plots.style import FORMATS, THEMES, check_target, save
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.folder import exports_folder, find_run
from gaitsim.runs.snapshot import RunSnapshot

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
    numbers = parse_individuals(generation, generations, member)
    _check_options(
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
    if kind == "all":
        _plot_all(request, numbers, parse_body_changes(damage, world), out, format or "png")
    else:
        _plot(kind, request, numbers, parse_body_changes(damage, world), out, format)


def _plot(
    kind: PlotKind,
    request: Request,
    numbers: Sequence[Choice],
    changed: BodyChange,
    out: Path | None,
    format: PlotFormat | None,
) -> None:
    if out is not None:
        choose_format(format, out, FORMATS, "png", "plots")
        check_target(out)
    if KINDS[kind].shows_motion:
        request = _with_individuals(request, numbers, changed)
    members = request.run.members if kind == "gaits" else None
    if members is None:
        figure = KINDS[kind].draw(request)
    else:
        with Progress("naming gaits", "members", len(members.scores)) as progress:
            figure = KINDS[kind].draw(replace(request, progress=progress.advance))
    path = out or exports_folder(request.run.path) / f"{file_stem(kind, request)}.{format or 'png'}"
    save(figure, path, request.theme)
    report_files(path)
    echo(path)


def _plot_all(
    request: Request,
    numbers: Sequence[Choice],
    changed: BodyChange,
    out: Path | None,
    format: PlotFormat,
) -> None:
    """Plot every kind that applies; report why the others do not."""
    if out is not None and out.exists() and not out.is_dir():
        raise GaitsimError(
            f"--kind all writes several files, and {out} is a file",
            where="--out",
            allowed="a folder, created if missing",
        )
    request = _with_individuals(request, numbers, changed)
    folder = out or exports_folder(request.run.path)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with Progress("plots", "kinds", len(KINDS)) as progress:
        for kind in KINDS:
            try:
                if kind == "channel" and request.channel is None:
                    _check_channel(request)
                # --channel is only for the kind "channel" here.
                one = request if kind == "channel" else replace(request, channel=None)
                figure = KINDS[kind].draw(one)
            except NothingToPlotError as error:
                notice(f"No plot of kind {kind!r}: {error.what}")
            else:
                path = folder / f"{file_stem(kind, one)}.{format}"
                save(figure, path, request.theme)
                report_files(path)
                echo(path)
            progress.advance()


def _check_channel(request: Request) -> None:
    """Reject a default channel that a different kind of plot already draws."""
    name = default_channel(request.individual)
    if name in KINDS_OF_CHANNELS:
        raise NothingToPlotError(
            f"{KINDS_OF_CHANNELS[name]!r} draws the channel {name!r}; choose a different channel "
            "with --channel"
        )


def _with_individuals(request: Request, numbers: Sequence[Choice], changed: BodyChange) -> Request:
    """Return the request with its individuals, on their changed bodies."""
    found = tuple(changed(request.run.individual(number)) for number in numbers or (None,))
    return replace(request, individuals=found)


def _check_options(kind: Kind, given: Mapping[str, object]) -> None:
    """Check that the kind of plot uses all given options."""
    supported = ALL_OPTIONS if kind == "all" else KINDS[kind].options
    unused = [name for name, value in given.items() if value and name not in supported]
    if unused:
        kinds = [one for one, known in KINDS.items() if {*unused} <= {*known.options}]
        subject, allowed = f"a plot of kind {kind!r}", ", ".join(sorted(supported))
        raise unsupported_flags(subject, unused, "--kind", kinds, allowed=allowed)
