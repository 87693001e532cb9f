"""Films: a curve, followed by one or several moving bodies."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.choices import VideoFormat
from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError, unknown
from gaitsim.gait.gait_files import check_folder
from gaitsim.render.encoder import (
    ALIASED,
    default_speed,
    encode,
    fastest_movement,
    format_speed,
    is_resolved,
)
from gaitsim.render.scene import THEMES, VIEWS, Picture, Scene
from gaitsim.render.scene.clip import Clip
from gaitsim.storage.files.atomic import write_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.render.plots.style import Theme

    Draw = Callable[[Theme, tuple[float, float]], Figure]
    """A function that draws a figure in a theme and a size (width and height in inches)."""


FORMATS = get_args(VideoFormat)
FPS = {"mp4": 30.0, "gif": 25.0}
SIZES = {"mp4": (1280, 720), "gif": (640, 360)}
FASTEST = {"mp4": 120.0, "gif": 50.0}  # browsers slow down faster GIFs
MIN_PIXELS, MAX_PIXELS = 64, 4096  # pixels
SPEEDS = 0.01, 100.0


@dataclass(frozen=True)
class RenderSettings:
    """The size, speed, view and colours of a video.

    Attributes:
        format: file format, one of `FORMATS`.
        size: width and height, pixels; None for the format's default.
        fps: frames per second; None for the format's default.
        speed: speed of the motion, where 1 is real time; None chooses real time, or slow motion for
            movements too fast for the frame rate.
        view: name of a view in `gaitsim.render.scene.VIEWS`.
        theme: name of a theme in `gaitsim.render.scene.THEMES`.
        intro: whether the video begins with the curve.
    """

    format: str = "mp4"
    size: tuple[int, int] | None = None
    fps: float | None = None
    speed: float | None = None
    view: str = "iso"
    theme: str = "light"
    intro: bool = True

    def __post_init__(self) -> None:
        for name, known in (("format", FORMATS), ("view", VIEWS), ("theme", THEMES)):
            if getattr(self, name) not in known:
                raise unknown(name, getattr(self, name), known, where=f"--{name}")
        self._check_size()
        fastest = FASTEST[self.format]
        if not 1 <= self.rate <= fastest:
            raise GaitsimError(
                f"invalid frame rate: {self.fps:g} frames per second",
                where="--fps",
                allowed=f"1 to {fastest:g} for {self.format.upper()}",
            )
        if self.speed is not None and not SPEEDS[0] <= self.speed <= SPEEDS[1]:
            raise GaitsimError(
                f"invalid speed: {self.speed:g}",
                where="--speed",
                allowed=f"{SPEEDS[0]:g} to {SPEEDS[1]:g}; 1 is real time",
            )

    def _check_size(self) -> None:
        width, height = self.pixels
        where, allowed = "--size", f"{MIN_PIXELS}x{MIN_PIXELS} to {MAX_PIXELS}x{MAX_PIXELS}"
        if not (MIN_PIXELS <= width <= MAX_PIXELS and MIN_PIXELS <= height <= MAX_PIXELS):
            raise GaitsimError(
                f"invalid size of a video: {width}x{height} pixels", where=where, allowed=allowed
            )
        if self.format == "mp4" and (width % 2 or height % 2):
            raise GaitsimError(
                f"invalid size of an MP4: {width}x{height} pixels; H.264 requires even numbers",
                where=where,
                allowed=f"{allowed}, both even",
                remedy=f"--size {width + width % 2}x{height + height % 2}",
            )

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.size or SIZES[self.format]

    @property
    def rate(self) -> Fraction:
        """Frames per second."""
        fps = FPS[self.format] if self.fps is None else self.fps
        return Fraction(fps if np.isfinite(fps) else 0).limit_denominator(1001)


MARGIN = 0.05  # margin around the figure, as a share of the smaller side
_LETTERS = 95.0  # dots per inch of the figure, for legible letters
_WIDTHS = 3.4, 5.6  # minimum and maximum width of the figure in inches, so that its labels fit


def figure_picture(draw: "Draw", size: tuple[int, int], theme: str) -> Picture:
    """Draw a figure in the size (width and height in pixels) and the colours of a video."""
    from io import BytesIO

    from matplotlib.image import imread

    from gaitsim.render.plots.style import THEMES as PLOT_THEMES, picture

    width, height = size
    edge = round(MARGIN * min(width, height))
    dots = (width - 2 * edge) / float(np.clip((width - 2 * edge) / _LETTERS, *_WIDTHS))
    colours = replace(PLOT_THEMES[theme], background=THEMES[theme].ground)
    # Matplotlib truncates sizes; a hundredth of a pixel more compensates for rounding errors.
    inches = ((width - 2 * edge + 0.01) / dots, (height - 2 * edge + 0.01) / dots)
    drawn = picture(draw(colours, inches), "png", colours, dots)
    curve = np.round(imread(BytesIO(drawn)) * 255).astype(np.uint8)
    framed = np.empty((height, width, 4), dtype=np.uint8)
    framed[:] = curve[0, -1]
    framed[edge : height - edge, edge : width - edge] = curve
    return framed


INTRO, CROSSFADE = 1.5, 0.4  # seconds; the crossfade is the end of the intro
ORBIT = 10.0  # minimum duration of a turn around the body, seconds


class Film:
    """A film of one body, or of several side by side, that begins with a curve.

    Args:
        clips: clips to show.
        settings: size, speed, view and colours.
        heading: first line of text, and the parts of the second line.
        curve: function that draws the figure at the beginning.
        leader: index of the clip that stays visible when the bodies are too far apart to show all.

    Attributes:
        speed: speed of the motion; 1 is real time.
    """

    def __init__(
        self,
        clips: Sequence[Clip],
        settings: RenderSettings,
        heading: tuple[str, Sequence[str]],
        curve: "Draw",
        leader: int = 0,
    ) -> None:
        self.settings, self._figure = settings, curve
        self._frequency = fastest_movement((clip.skeleton for clip in clips), float(settings.rate))
        self.speed = settings.speed or self._default_speed
        title, details = heading
        slowed = (format_speed(self.speed),) if self.speed != 1 else ()
        self.scene = Scene(
            clips,
            settings.pixels,
            settings.view,
            settings.theme,
            (title, "   ".join((*details, *slowed))),
            leader=leader,
        )
        ratio = float(settings.rate) / self.speed
        # The tolerance keeps a last frame that rounding errors would remove.
        self._moving = int(self.scene.seconds * ratio + 1e-6) + 1
        self._intro = round(INTRO * settings.rate) if settings.intro else 0

    def __len__(self) -> int:
        """Return the number of pictures."""
        return self._intro + self._moving

    @property
    def _default_speed(self) -> float:
        return default_speed(self._frequency, float(self.settings.rate), SPEEDS[0])

    @property
    def warning(self) -> str:
        """A warning if the movement is too fast for the frame rate, with a remedy; else ''."""
        rate = float(self.settings.rate)
        if is_resolved(self._frequency, rate, self.speed, ALIASED):
            return ""
        return (
            f"At speed {self.speed:g}, a video with {rate:g} frames per second cannot show a "
            f"movement of {self._frequency:.3g} Hz: each cycle has "
            f"{rate / (self._frequency * self.speed):.2g} frames. "
            f"Try speed {self._default_speed:g}."
        )

    def write(self, path: Path, advance: Callable[[], object] = lambda: None) -> None:
        """Write the video, picture by picture.

        Args:
            path: path of the file.
            advance: function called after each picture.
        """
        check_folder(path)
        samples = self._samples() if self.settings.format == "gif" else ()

        def pictures() -> Iterator[Picture]:
            for picture in self.pictures():
                yield picture
                advance()

        encode(
            pictures(),
            path,
            format=self.settings.format,
            size=self.settings.pixels,
            fps=self.settings.rate,
            samples=samples,
            exact=THEMES[self.settings.theme].exact,
        )

    def pictures(self) -> Iterator[Picture]:
        """Yield the pictures one at a time."""
        if self._intro:
            curve, first = self._curve(), self._draw(0)
            fading = min(round(CROSSFADE * self.settings.rate), self._intro)
            for number in range(self._intro):
                share = max(number + 1 - (self._intro - fading), 0) / (fading + 1)
                yield _blend(curve, first, share)
        for number in range(self._moving):
            yield self._draw(number)

    def _draw(self, number: int) -> Picture:
        """Draw a picture, counted from the end of the intro."""
        shown = number / float(self.settings.rate)
        turn = 360 / max(self._moving / float(self.settings.rate), ORBIT)
        return self.scene.draw(
            shown * self.speed, turn * shown if self.settings.view == "orbit" else 0.0
        )

    def _samples(self) -> list[Picture]:
        """Return pictures with all colours of the video."""
        numbers = {0, self._moving // 3, 2 * self._moving // 3, self._moving - 1}
        moving = [self._draw(number) for number in sorted(numbers)]
        return [*moving, self._curve()] if self._intro else moving

    def _curve(self) -> Picture:
        return figure_picture(self._figure, self.settings.pixels, self.settings.theme)


def _blend(one: Picture, other: Picture, share: float) -> Picture:
    if not share:
        return one
    return np.round(one * np.float32(1 - share) + other * np.float32(share)).astype(np.uint8)


SIZE = 1280, 720


def write_still(
    skeleton: Skeleton,
    path: Path,
    title: str = "",
    details: str = "",
    *,
    size: tuple[int, int] = SIZE,
    pins: NDArray[np.float64] | None = None,
) -> None:
    """Write the first frame of a body as a PNG, with its front and the names of its feet.

    Args:
        skeleton: motion of the body.
        path: path of the file.
        title: first line of text.
        details: second line of text.
        size: width and height, pixels.
        pins: places to mark with a white circle, such as of passive joints, (pins, 3) m.
    """
    from PIL import Image

    check_folder(path)
    clip = Clip(_frozen(skeleton), title, details, named=True, pins=pins)
    picture = Scene([clip], size, "iso", "light").draw(0.0)
    data = BytesIO()
    Image.fromarray(picture[..., :3]).save(data, format="PNG")
    write_bytes(path, data.getvalue())


def _frozen(skeleton: Skeleton) -> Skeleton:
    """Return the first frame of a motion."""
    over_time = ("segments", "contacts", "touching", "centre", "poses")
    kept = {name: getattr(skeleton, name) for name in over_time}
    return replace(
        skeleton, **{name: array[:1] for name, array in kept.items() if array is not None}
    )
