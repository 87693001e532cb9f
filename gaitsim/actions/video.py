"""`gaitsim video`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator

from gaitsim.actions.action import RUN, SeveralIndividuals, argument, choose_format
from gaitsim.choices import Theme, VideoFormat, VideoView
from gaitsim.contracts.plugin import option
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.individual import Individual


def parse_size(value: Any) -> Any:
    """Return the width and height in pixels of a string such as '1280x720'."""
    if not isinstance(value, str):
        return value
    parts = value.lower().replace("×", "x").split("x")
    if len(parts) != 2 or not all(part.isdecimal() and len(part) < 7 for part in parts):
        raise GaitsimError(
            f"invalid size: {value!r}",
            where="--size",
            allowed="WIDTHxHEIGHT in pixels, such as 1280x720",
        )
    return int(parts[0]), int(parts[1])


class MakeVideo(SeveralIndividuals):
    """Make a video of the champion: MP4 or GIF.

    [bold]Examples[/bold]

    gaitsim video spider

    gaitsim video spider --generations 1,10,150 --view side

    gaitsim video spider --damage "L2 lost"

    gaitsim video walker --world "friction 0.4"

    gaitsim video spider --out spider.gif --speed 0.5 --theme dark --no-intro
    """

    title: ClassVar[str] = "Video"

    run: str = argument(RUN, "RUN")
    format: VideoFormat | None = option(
        None, "MP4 (H.264) or GIF", unset="from the extension of --out, otherwise 'mp4'"
    )
    out: Path | None = option(None, "file to write", unset="a file in the run's exports folder")
    view: VideoView = option("iso", "direction of the camera")
    theme: Theme = option("light", "colour theme")
    size: Annotated[tuple[int, int], BeforeValidator(parse_size)] | None = option(
        None,
        "size in pixels",
        unset="1280x720, or 640x360 for a GIF",
        allowed="WIDTHxHEIGHT",
        placeholder="WxH",
    )
    fps: float | None = option(
        None,
        "frames per second",
        unset="30, or 25 for a GIF",
        allowed="1 to 120, or to 50 for a GIF",
    )
    speed: float | None = option(
        None,
        "playback speed: 0.25 is slow motion, 4 is time lapse",
        unset="real time, or slow motion for movements too fast to see, such as wing beats",
        allowed="0.01 to 100; 1 is real time",
    )
    intro: bool = option(True, "begin the video with the curve of the score over the generations")

    @classmethod
    def check(cls, individual: "Individual") -> None:
        """Check that the body can be drawn."""
        from gaitsim.render.scene.clip import clip_of

        clip_of(individual)

    def do(self) -> None:
        """Make the video."""
        from gaitsim.console.interrupts import all_or_nothing
        from gaitsim.console.printing import echo, notice, report_files, status
        from gaitsim.console.progress_bar import Progress

        with all_or_nothing():
            with status("Simulating the champion …"):
                from gaitsim.gait.gait_files import check_folder
                from gaitsim.render.encoder import format_speed
                from gaitsim.render.film import FORMATS, RenderSettings
                from gaitsim.render.video import Video
                from gaitsim.storage.files.folder import exports_folder
                from gaitsim.storage.snapshot import RunSnapshot

                chosen = choose_format(self.format, self.out, FORMATS, "mp4", "videos")
                settings = RenderSettings(
                    chosen, self.size, self.fps, self.speed, self.view, self.theme, self.intro
                )
                individuals = self.choices()
                if self.out is not None:
                    check_folder(self.out)
                opened = RunSnapshot.find(self.run)
                film = Video(opened, individuals, settings, self.changed)
            if film.warning:
                notice(f"Warning: {film.warning}")
            path = self.out or exports_folder(opened.path) / film.name
            with Progress(path.name, "pictures", len(film)) as progress:
                film.write(path, progress.advance)
        report_files(path)
        width, height = settings.pixels
        echo(
            f"{path}: {len(film)} pictures of {width} × {height} at {float(settings.rate):g} per "
            f"second, {float(len(film) / settings.rate):.1f} s"
            + (f", {format_speed(film.speed)}" if film.speed != 1 else "")
        )
