"""The size, speed, view and colours of a video."""

from dataclasses import dataclass
from fractions import Fraction
from typing import get_args

import numpy as np

from gaitsim.choices import VideoFormat
from gaitsim.errors import GaitsimError, unknown
from gaitsim.render.scene import THEMES, VIEWS

FORMATS = get_args(VideoFormat)
FPS = {"mp4": 30.0, "gif": 25.0}
SIZES = {"mp4": (1280, 720), "gif": (640, 360)}
FASTEST = {"mp4": 120.0, "gif": 50.0}  # browsers slow a GIF down that is faster
SMALLEST, LARGEST = 64, 4096  # pixels
SPEEDS = 0.01, 100.0


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
        intro: whether it begins with its curve.

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
