"""Videos of a run: its fitness curve, then its champions as they move."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import get_args

import numpy as np

from gaitsim.choices import VideoFormat
from gaitsim.errors import GaitsimError, unknown
from gaitsim.gait.files.writer import check_folder
from gaitsim.individual import Asked, Individual
from gaitsim.render.encoder import encode
from gaitsim.render.individual_clip import clip_of
from gaitsim.render.intro import fitness_picture
from gaitsim.render.plots.channels import count_trials
from gaitsim.render.plots.labels import score_words
from gaitsim.render.scene import THEMES, VIEWS, Picture, Scene
from gaitsim.render.scene.labels import ROW, ROWS, small_letters
from gaitsim.render.tempo import ALIASED, rhythm, shows, speed_words, usual_speed
from gaitsim.runs.snapshot import RunSnapshot

FORMATS = get_args(VideoFormat)
FPS = {"mp4": 30.0, "gif": 25.0}
SIZES = {"mp4": (1280, 720), "gif": (640, 360)}
FASTEST = {"mp4": 120.0, "gif": 50.0}  # browsers slow a GIF down that is faster
SMALLEST, LARGEST = 64, 4096  # pixels
SPEEDS = 0.01, 100.0

INTRO, CROSSFADE = 1.5, 0.4  # seconds, the latter the last of the former
ORBIT = 10.0  # seconds that a turn around the body takes at least


@dataclass(frozen=True)
class RenderSettings:
    """The size, speed, view and colours of a video.

    Attributes:
        format: one of `FORMATS`.
        size: width and height, pixels; None takes the format's.
        fps: pictures a second; None takes the format's.
        speed: of the motion, 1 is real time; None is real time, or slow motion where pictures
            cannot show so fast a movement.
        view: one of `gaitsim.render.scene.VIEWS`.
        theme: one of `gaitsim.render.scene.THEMES`.
        intro: whether it begins with the fitness curve.

    Raises:
        GaitsimError: says which of them cannot be, and what can.
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
                f"{self.fps:g} pictures a second cannot be shown",
                where="--fps",
                allowed=f"1 to {fastest:g} in {self.format.upper()}",
            )
        if self.speed is not None and not SPEEDS[0] <= self.speed <= SPEEDS[1]:
            raise GaitsimError(
                f"a speed of {self.speed:g} cannot be shown",
                where="--speed",
                allowed=f"{SPEEDS[0]:g} to {SPEEDS[1]:g}; 1 is real time",
            )

    def _check_size(self) -> None:
        width, height = self.pixels
        where, allowed = "--size", f"{SMALLEST}x{SMALLEST} to {LARGEST}x{LARGEST}"
        if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
            raise GaitsimError(
                f"a video of {width}x{height} pixels is too small or too large",
                where=where,
                allowed=allowed,
            )
        if self.format == "mp4" and (width % 2 or height % 2):
            raise GaitsimError(
                f"an MP4 cannot be {width}x{height} pixels: H.264 wants even numbers",
                where=where,
                allowed=f"{allowed}, both even",
                remedy=f"--size {width + width % 2}x{height + height % 2}",
            )

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height."""
        return self.size or SIZES[self.format]

    @property
    def rate(self) -> Fraction:
        """Pictures a second."""
        fps = FPS[self.format] if self.fps is None else self.fps
        return Fraction(fps if np.isfinite(fps) else 0).limit_denominator(1001)


class Video:
    """A video of a champion of a run, or of a race of several.

    Args:
        run: whose champions are shown.
        generations: whose best, or which members; () for the best of all.
        settings: size, speed, view and colours; the defaults of `RenderSettings` for None.
        changed: moves an individual on a changed body, such as `with_world` with a world.

    Raises:
        RunError: there is no such generation, or no champion.
        GaitsimError: a body cannot be changed like this, or there is no room to name so many.
    """

    def __init__(
        self,
        run: RunSnapshot,
        generations: Sequence[Asked] = (),
        settings: RenderSettings | None = None,
        changed: Callable[[Individual], Individual] = lambda individual: individual,
    ) -> None:
        self.run, self.settings = run, settings or RenderSettings()
        shown = [changed(run.individual(one)) for one in generations or (None,)]
        self.generations = tuple(one.generation for one in shown)
        self._stem = shown[0].stem
        self._check_room(len(shown))
        if len(shown) > 1:
            clips = [clip_of(one, *_words(one), tag=str(one.generation)) for one in shown]
        else:
            clips = [clip_of(shown[0])]
        # A motion whose frames all have a picture is shown as it is.
        fast = [clip.skeleton for clip in clips if clip.skeleton.frame_rate > self.settings.rate]
        self._rhythm = max(map(rhythm, fast), default=0.0)
        self.speed = self.settings.speed or self._usual_speed
        self.scene = Scene(
            clips,
            self.settings.pixels,
            self.settings.view,
            self.settings.theme,
            (shown[0].name, self._details(shown)),
            leader=int(np.argmax([one.score for one in shown])),
        )
        ratio = float(self.settings.rate) / self.speed
        # What is a frame but for rounding is one.
        self._moving = int(self.scene.seconds * ratio + 1e-6) + 1
        self._intro = round(INTRO * self.settings.rate) if self.settings.intro else 0

    def __len__(self) -> int:
        """Return the number of pictures."""
        return self._intro + self._moving

    def _details(self, shown: Sequence[Individual]) -> str:
        """Return the second line of the picture."""
        one = shown[0]
        details = ["   ".join(_words(one)) if len(shown) == 1 else "the best of each generation"]
        if (trials := count_trials(one)) > 1:
            details.append(f"first of {trials} trials")
        if self.speed != 1:
            details.append(speed_words(self.speed))
        return "   ".join(details)

    @property
    def _usual_speed(self) -> float:
        return usual_speed(self._rhythm, float(self.settings.rate), SPEEDS[0])

    @property
    def caution(self) -> str:
        """Why this speed is too fast for the pictures, and what to try; '' where it is not."""
        rate = float(self.settings.rate)
        if shows(self._rhythm, rate, self.speed, ALIASED):
            return ""
        return (
            f"At a speed of {self.speed:g}, {rate:g} pictures a second cannot show a body that "
            f"moves to and fro {self._rhythm:.3g} times a second: "
            f"{rate / (self._rhythm * self.speed):.2g} pictures each. "
            f"Try a speed of {self._usual_speed:g}."
        )

    @property
    def name(self) -> str:
        """The default name of its file."""
        numbers = "-".join(map(str, self.generations))
        if len(self.generations) == 1:
            return f"video-{self._stem}.{self.settings.format}"
        many = f"{self.generations[0]}-to-{self.generations[-1]}" if len(numbers) > 60 else numbers
        return f"video-generations-{many}.{self.settings.format}"

    def write(self, path: Path, advance: Callable[[], object] = lambda: None) -> None:
        """Write the video, picture by picture.

        Args:
            path: the file.
            advance: called after each picture.

        Raises:
            RunError: the file cannot be written.
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
            curve, first = (
                fitness_picture(self.run, self.settings.pixels, self.settings.theme),
                self._draw(0),
            )
            fading = min(round(CROSSFADE * self.settings.rate), self._intro)
            for number in range(self._intro):
                share = max(number + 1 - (self._intro - fading), 0) / (fading + 1)
                yield _mixed(curve, first, share)
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
        return [self._draw(number) for number in sorted(numbers)] + (
            [fitness_picture(self.run, self.settings.pixels, self.settings.theme)]
            if self._intro
            else []
        )

    def _check_room(self, bodies: int) -> None:
        width, height = self.settings.pixels
        most = int(ROWS * height / (ROW * small_letters((width, height))))
        if bodies > max(most, 1):
            raise GaitsimError(
                f"{bodies} bodies do not fit into {width}x{height} pixels",
                where="--generations",
                allowed=f"{most} of them at this size",
                remedy="show fewer of them, or make the picture larger with --size",
            )


def _words(shown: Individual) -> tuple[str, str]:
    return shown.label, score_words(shown)


def _mixed(one: Picture, other: Picture, share: float) -> Picture:
    if not share:
        return one
    return np.round(one * np.float32(1 - share) + other * np.float32(share)).astype(np.uint8)
