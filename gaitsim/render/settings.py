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
                f"invalid size of a video: {width}x{height} pixels",
                where=where,
                allowed=allowed,
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
