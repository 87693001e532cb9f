"""Films: a curve, followed by one or several moving bodies."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.gait.gait_files import check_folder
from gaitsim.render.encoder import encode
from gaitsim.render.intro import figure_picture
from gaitsim.render.scene import THEMES, Picture, Scene
from gaitsim.render.scene.clip import Clip
from gaitsim.render.settings import SPEEDS, RenderSettings
from gaitsim.render.tempo import (
    ALIASED,
    default_speed,
    format_speed,
    is_resolved,
    movement_frequency,
)

if TYPE_CHECKING:
    from gaitsim.render.intro import Draw

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
        # A motion with a frame rate no higher than the video is never aliased.
        fast = [clip.skeleton for clip in clips if clip.skeleton.frame_rate > settings.rate]
        self._frequency = max(map(movement_frequency, fast), default=0.0)
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
