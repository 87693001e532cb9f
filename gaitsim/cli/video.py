"""`gaitsim video`."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.choices import Theme, VideoFormat, VideoView
from gaitsim.cli.console import echo


def video(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    format: Annotated[
        VideoFormat | None,
        typer.Option(help="MP4 (H.264) or GIF. Default: as --out ends, or mp4."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File to write. Default: in the run's exports folder.")
    ] = None,
    generation: Annotated[
        int | None, typer.Option(min=1, help="The best of this generation. Default: of all.")
    ] = None,
    generations: Annotated[
        str | None,
        typer.Option(metavar="N,N,…", help="The best of several generations, side by side."),
    ] = None,
    view: Annotated[VideoView, typer.Option(help="From where the camera looks.")] = "iso",
    theme: Annotated[Theme, typer.Option(help="Colours.")] = "light",
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels. Default: 1280x720, or 640x360 for a GIF."),
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help="Pictures a second. Default: 30, or 25 for a GIF.")
    ] = None,
    speed: Annotated[float, typer.Option(help="0.25 is slow motion, 4 is time lapse.")] = 1.0,
    intro: Annotated[bool, typer.Option(help="Begin with the fitness curve.")] = True,
) -> None:
    """Make a video of the champion as it moves: MP4 or GIF.

    [bold]Examples[/bold]

    gaitsim video spider

    gaitsim video spider --generations 1,50,300 --view side

    gaitsim video spider --out spider.gif --speed 0.5 --theme dark --no-intro
    """
    import sys

    from gaitsim.cli.console import notice, wrote
    from gaitsim.cli.generations import asked_generations
    from gaitsim.cli.interrupts import interruptible
    from gaitsim.cli.progress_bar import Progress
    from gaitsim.gait.files.writer import check_folder
    from gaitsim.render.video import RenderSettings, Video
    from gaitsim.runs.files.folder import find_run
    from gaitsim.runs.reader import Run

    chosen = _format(format, out)
    settings = RenderSettings(chosen, _size(size), fps, speed, view, theme, intro)
    wanted = asked_generations(generation, generations)
    if out is not None:
        check_folder(out)
    opened = Run(find_run(run))
    try:
        with interruptible():
            made = Video(opened, wanted, settings)
            path = out or opened.exports() / made.name
            with Progress(path.name, "pictures", len(made)) as progress:
                made.write(path, progress.advance)
    except KeyboardInterrupt:
        notice("Stopped; nothing was written.")
        sys.exit(130)
    wrote(path)
    width, height = settings.pixels
    echo(
        f"{path}: {len(made)} pictures of {width} × {height} at {float(settings.rate):g} a second, "
        f"{float(len(made) / settings.rate):.1f} s"
    )


def _format(format: VideoFormat | None, out: Path | None) -> str:
    """The format asked for, or the one that the file's name ends with."""
    from gaitsim.errors import GaitsimError
    from gaitsim.render.video import FORMATS

    if format is not None or out is None:
        return format or "mp4"
    ending = out.suffix[1:].lower()
    if ending not in FORMATS:
        raise GaitsimError(
            f"{out} does not end with a format of videos",
            where="--out",
            allowed=", ".join(f".{known}" for known in FORMATS),
            remedy="give it such an ending, or say which with --format",
        )
    return ending


def _size(text: str | None) -> tuple[int, int] | None:
    from gaitsim.errors import GaitsimError

    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if len(parts) != 2 or not all(part.isdecimal() and len(part) < 7 for part in parts):
        raise GaitsimError(
            f"{text!r} is no size of a picture",
            where="--size",
            allowed="width x height in pixels, such as 1280x720",
        )
    return int(parts[0]), int(parts[1])
