"""`gaitsim video`."""

from typing import Annotated

import typer

from gaitsim.choices import Theme, VideoFormat, VideoView
from gaitsim.cli.options import BestOf, Damage, Engine, ExportFile, MemberOf, RunName, World
from gaitsim.console.interrupts import all_or_nothing
from gaitsim.console.printing import echo, notice, report_files, status
from gaitsim.console.progress_bar import Progress


def video(
    run: RunName,
    format: Annotated[
        VideoFormat | None,
        typer.Option(
            help="MP4 (H.264) or GIF. Default: from the extension of --out, otherwise 'mp4'."
        ),
    ] = None,
    out: ExportFile = None,
    generation: BestOf = None,
    member: MemberOf = None,
    damage: Damage = None,
    world: World = None,
    engine: Engine = None,
    generations: Annotated[
        str | None,
        typer.Option(
            metavar="N,N,…",
            help="Race the best individuals of several generations side by side, such as 1,50,300.",
        ),
    ] = None,
    view: Annotated[VideoView, typer.Option(help="Direction of the camera.")] = "iso",
    theme: Annotated[Theme, typer.Option(help="Colour theme.")] = "light",
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH", help="Size in pixels. Default: 1280x720, or 640x360 for a GIF."
        ),
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help="Frames per second. Default: 30, or 25 for a GIF.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(
            help="Playback speed: 0.25 is slow motion, 4 is time lapse. Default: real time, "
            "or slow motion for movements too fast to see, such as wing beats."
        ),
    ] = None,
    intro: Annotated[
        bool, typer.Option(help="Begin the video with the curve of the score over the generations.")
    ] = True,
) -> None:
    """Make a video of the champion: MP4 or GIF.

    [bold]Examples[/bold]

    gaitsim video spider

    gaitsim video spider --generations 1,50,300 --view side

    gaitsim video spider --damage "L2 lost"

    gaitsim video walker --world "friction 0.4"

    gaitsim video spider --out spider.gif --speed 0.5 --theme dark --no-intro
    """
    with all_or_nothing():
        # These imports take most of the start-up time.
        with status("Simulating the champion …"):
            from gaitsim.cli.parsing import (
                choose_format,
                parse_body_changes,
                parse_individuals,
                parse_size,
            )
            from gaitsim.gait.gait_files import check_folder
            from gaitsim.render.encoder import format_speed
            from gaitsim.render.film import FORMATS, RenderSettings
            from gaitsim.render.video import Video
            from gaitsim.runs.files.folder import exports_folder, find_run
            from gaitsim.runs.snapshot import RunSnapshot

            chosen = choose_format(format, out, FORMATS, "mp4", "videos")
            settings = RenderSettings(chosen, parse_size(size), fps, speed, view, theme, intro)
            individuals = parse_individuals(generation, generations, member)
            if out is not None:
                check_folder(out)
            changed = parse_body_changes(damage, world, engine)
            opened = RunSnapshot(find_run(run))
            film = Video(opened, individuals, settings, changed)
        if film.warning:
            notice(f"Warning: {film.warning}")
        path = out or exports_folder(opened.path) / film.name
        with Progress(path.name, "pictures", len(film)) as progress:
            film.write(path, progress.advance)
    report_files(path)
    width, height = settings.pixels
    echo(
        f"{path}: {len(film)} pictures of {width} × {height} at {float(settings.rate):g} per "
        f"second, {float(len(film) / settings.rate):.1f} s"
        + (f", {format_speed(film.speed)}" if film.speed != 1 else "")
    )
