"""The labels and captions of a picture, fitted to its width."""

import re
from bisect import bisect_left
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.colours import LEFT, side_words
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.scene.themes import SceneTheme
from gaitsim.render.ticks import format_round_length

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.path import Path


SMALL = 0.25  # metres; distances of smaller bodies are in centimetres


def format_time(seconds: float) -> str:
    """Format a time."""
    return f"{seconds:.2f} s"


def format_moment(clip: Clip, pose: Pose, seconds: float) -> str:
    """Format time, distance, a flying body's altitude, and a driver's command; '' for a still."""
    if not clip.seconds:
        return ""
    away = float(np.hypot(*(pose.middle - clip.path[0])[:2]))
    now = min(seconds, clip.seconds)
    said = clip.said[round(now * clip.skeleton.frame_rate)] if clip.said else ""
    return _join(clip, now, away, float(pose.middle[2]) + clip.floor, said)


def widest_moment(clip: Clip) -> str:
    """Return a string about as wide as the widest result of `format_moment`."""
    away = float(np.hypot(*(clip.path - clip.path[0])[:, :2].T).max())
    altitude = clip.path[:, 2] + clip.floor
    said = max(clip.said, key=len, default="")
    return _join(clip, clip.seconds, away, float(altitude[np.abs(altitude).argmax()]), said)


def format_progress(clip: Clip, pose: Pose, seconds: float) -> str:
    """Format the distance or altitude of one of several bodies, and when its motion ended."""
    away = float(np.hypot(*(pose.middle - clip.path[0])[:2]))
    altitude = float(pose.middle[2]) + clip.floor
    text = (
        f"altitude {format_length(clip, altitude)}"
        if clip.flies
        else f"distance {format_length(clip, away)}"
    )
    return text + (f", ended at {clip.seconds:.2f} s" if seconds > clip.seconds + 1e-6 else "")


def format_length(clip: Clip, metres: float) -> str:
    """Format a length at the scale of a body."""
    # All digits have the same width, so a constant unit keeps the text from jumping.
    small = clip.anatomy.span < SMALL
    return (f"{100 * metres:.1f} cm" if small else f"{metres:.2f} m").replace("-", "−")


def _join(clip: Clip, seconds: float, away: float, altitude: float, said: str) -> str:
    words = [format_time(seconds), f"distance {format_length(clip, away)}"]
    if clip.flies:
        words.append(f"altitude {format_length(clip, altitude)}")
    return "   ".join([*words, said] if said else words)


DPI = 64  # a power of two, so that sizes in pixels are exact in inches
POINT = 72 / DPI  # points per pixel; Matplotlib takes line widths and letters in points
MIN_LETTERS = 9.0  # pixels; smaller letters are illegible
FONT = "DejaVu Sans"  # included in Matplotlib; all its digits have the same width
ROW = 1.45  # height of a row in the table of several bodies, in heights of letters
ROWS = 0.5  # maximum height of this table, as a share of the picture


class Labels:
    """A picture's title, details, clock and legend, and a row for each of several bodies.

    Args:
        figure: figure to write in, at `DPI`.
        size: width and height of the picture, pixels.
        clips: clips in the picture.
        theme: colours of the picture.
        colours: colours of the bodies.
        grid: distance between the lines on the ground, m.
        heading: title and details.

    Attributes:
        still: artists that never change.
        clock: artist of the clock, which changes.
    """

    def __init__(
        self,
        figure: "Figure",
        size: tuple[int, int],
        clips: Sequence[Clip],
        theme: SceneTheme,
        colours: Sequence[str],
        grid: float,
        heading: tuple[str, str],
    ) -> None:
        self._figure, self._clips, self._theme = figure, clips, theme
        self.still: list[Any] = []
        width, height = size
        unit = relative_size(width, height)
        pad, several = 22 * unit, len(clips) > 1
        self._pad, self._small, big = pad, small_letters(size), max(21 * unit, MIN_LETTERS)
        room, top = width - 2 * pad, height - pad
        title = self._text(pad, top, heading[0], big, weight="bold", va="top")
        self._fit(title, room)
        under = top - 1.35 * _size(title)
        details = self._text(pad, under, heading[1], self._small, colour="faint", va="top")
        self._fit(details, room)
        longest = format_time(max(clip.seconds for clip in clips))
        if not several:
            longest = widest_moment(clips[0])
        clock = self._text(pad, pad, longest, big)
        self._fit(clock, room)
        used = self._box(clock).width + 2 * pad
        self.clock, self._clock_size = self._changing(), _size(clock)
        self.still.pop().remove()
        self._legend(width - pad, pad, room - used, self._small, grid)
        self._progress: list[tuple[Any, tuple[float, float]]] = []
        if several:
            self._rows(under - 1.9 * self._small, room, colours)

    def set_clock(self, poses: Sequence[Pose], seconds: float) -> None:
        """Set the clock, and the rows of several bodies, to a moment."""
        if self._progress:
            now = format_time(min(seconds, max(one.seconds for one in self._clips)))
        else:
            now = format_moment(self._clips[0], poses[0], seconds)
        self.clock.set_paths([text_path(now, self._clock_size, (self._pad, self._pad))])
        for clip, pose, (artist, at) in zip(self._clips, poses, self._progress, strict=False):
            progress_text = format_progress(clip, pose, seconds)
            artist.set_paths([text_path(progress_text, self._small, at)])

    def _changing(self) -> Any:
        """Add an artist for text that changes."""
        from matplotlib.collections import PathCollection
        from matplotlib.transforms import IdentityTransform

        artist = PathCollection([], facecolors=self._theme.ink, edgecolors="none", zorder=9)
        artist.set_transform(IdentityTransform())
        return self._figure.add_artist(artist, clip=False)

    def _rows(self, top: float, room: float, colours: Sequence[str]) -> None:
        """Write the colour and the name of each body, and leave space for its distance."""
        size = self._small
        bottoms = [top - ROW * size * (number + 0.5) for number in range(len(self._clips))]
        for bottom, colour in zip(bottoms, colours, strict=True):
            self._sign(self._pad + 0.4 * size, bottom + 0.36 * size, size, "s", colour, True)
        left, last = self._pad + 1.3 * size, text_width("altitude −000.00 m", size)
        for column in ("title", "details"):
            rest = self._pad + room - left - last - size
            written = []
            for clip, bottom in zip(self._clips, bottoms, strict=True):
                text = self._text(left, bottom, getattr(clip, column), size)
                self._fit(text, max(rest, size))
                written.append(float(self._box(text).x1))
            left = max(written) + size
        self._progress = [(self._changing(), (left, bottom)) for bottom in bottoms]

    def _legend(self, right: float, bottom: float, room: float, size: float, grid: float) -> None:
        """Write the meaning of the markers and the step of the grid, as far as they fit.

        A flying body, whose grid varies with the altitude, has none.
        """
        skeleton = self._clips[0].skeleton
        if skeleton.contacts is None:
            return
        theme = self._theme
        scale = [(f"grid {format_round_length(grid)}", "", True)]
        feet = [("on the ground", theme.faint, True), ("in the air", theme.faint, False)]
        words = side_words(skeleton.contact_names)
        sides = [
            (word, {LEFT: theme.left}.get(side, theme.right), True) for side, word in words.items()
        ]
        hurt = [("damaged", theme.damaged, True)] if skeleton.damaged else []
        for entries in (
            [*hurt, *sides, *feet, *scale],
            [*hurt, *feet, *scale],
            [*hurt, *feet],
            [*hurt, *scale],
        ):
            before, at = len(self.still), right
            for word, colour, filled in reversed(entries):
                at = self._entry(at, bottom, word, colour, filled, size)
            if right - at <= room:
                return
            while len(self.still) > before:
                self.still.pop().remove()

    def _entry(
        self, right: float, bottom: float, words: str, colour: str, filled: bool, size: float
    ) -> float:
        """Write an entry of the legend from the right; return the right end of the next entry."""
        text = self._text(right, bottom, words, size, colour="faint", ha="right")
        left = float(self._box(text).x0) - 0.6 * size
        if colour:
            self._sign(left - 0.2 * size, bottom + 0.36 * size, size, "o", colour, filled)
            left -= 0.8 * size
        return left - 0.6 * size

    def _sign(
        self, x: float, y: float, size: float, marker: str, colour: str, filled: bool
    ) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.transforms import IdentityTransform

        sign = Line2D(
            [x],
            [y],
            linestyle="none",
            marker=marker,
            markersize=(0.75 if filled else 0.62) * size * POINT,
            markerfacecolor=colour if filled else "none",
            markeredgecolor=self._theme.limb_edge if filled else colour,
            markeredgewidth=(0.05 if filled else 0.15) * size * POINT,
            transform=IdentityTransform(),
            zorder=9,
        )
        self.still.append(self._figure.add_artist(sign))

    def _text(
        self,
        x: float,
        y: float,
        words: str,
        size: float,
        *,
        colour: str = "ink",
        weight: str = "normal",
        va: str = "baseline",
        ha: str = "left",
    ) -> Any:
        """Write text; its size is in pixels."""
        from matplotlib.transforms import IdentityTransform

        text = self._figure.text(
            x,
            y,
            _printable(words),
            transform=IdentityTransform(),
            fontsize=size * POINT,
            color=getattr(self._theme, colour),
            fontweight=weight,
            family=FONT,
            va=va,
            ha=ha,
            parse_math=False,
            usetex=False,
            zorder=9,
        )
        self.still.append(text)
        return text

    def _fit(self, text: Any, room: float) -> None:
        """Make text fit, first by smaller letters, then by an ellipsis."""
        while self._box(text).width > room and _size(text) > 1.2 * MIN_LETTERS:
            text.set_fontsize(max(_size(text) / 1.1, MIN_LETTERS) * POINT)
        whole = text.get_text()
        if self._box(text).width <= room or len(whole) == 1:
            return

        def cut(kept: int) -> bool:
            """Keep the first `kept` letters; return whether they are still too wide."""
            text.set_text(whole[:kept].rstrip() + "…")
            return bool(self._box(text).width > room)

        cut(max(bisect_left(range(1, len(whole)), True, key=cut), 1))

    def _box(self, text: Any) -> Any:
        return text.get_window_extent(self._figure.canvas.get_renderer())  # type: ignore[attr-defined]


def relative_size(width: float, height: float) -> float:
    """Return the size of a picture relative to one of 960 × 720 pixels."""
    return max(min(width / 960, height / 720), 0.36)


def small_letters(size: tuple[int, int]) -> float:
    """Return the font size of small text in a picture, pixels."""
    return max(15 * relative_size(*size), MIN_LETTERS)


def text_width(words: str, size: float) -> float:
    """Return the width of text at a font size, both in pixels."""
    return size / 100 * float(_large_glyphs(words)[0][:, 0].max(initial=0.0))


def text_path(words: str, size: float, at: tuple[float, float], share: float = 0.0) -> "Path":
    """Return text as a path, which takes a tenth of the time to draw.

    Args:
        words: the text.
        size: size of the letters, pixels.
        at: a place on the base line, pixels.
        share: share of the text to the left of that place.
    """
    from matplotlib.path import Path

    large, codes = _large_glyphs(words)
    left = at[0] - share * text_width(words, size)
    return Path(size / 100 * large + np.array([left, at[1]]), codes)


def _large_glyphs(words: str) -> tuple[NDArray[np.float64], Any]:
    """Return the vertices and the codes of text with a font size of 100 pixels.

    Digits are laid out one by one, as texts that change differ only in them.
    """
    at, vertices, codes = 0.0, [np.empty((0, 2))], [np.empty(0, dtype=np.uint8)]
    for piece in re.findall(r"\d|\D+", _printable(words)):
        outline, kinds, advance = _layout(piece)
        vertices.append(outline + np.array([at, 0.0]))
        codes.append(kinds)
        at += advance
    return np.concatenate(vertices), np.concatenate(codes)


@lru_cache(1024)
def _layout(words: str) -> tuple[NDArray[np.float64], Any, float]:
    """Return a part of a text with a font size of 100 pixels, and the distance to the next."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    font = FontProperties(family=FONT)
    zero, longer = (TextPath((0, 0), text, size=100, prop=font) for text in ("0", words + "0"))
    vertices, digit = np.asarray(longer.vertices), np.asarray(zero.vertices)
    own = len(vertices) - len(digit)
    return vertices[:own], np.asarray(longer.codes)[:own], float((vertices[own:] - digit)[0, 0])


def _size(text: Any) -> float:
    return float(text.get_fontsize()) / POINT


def _printable(words: str) -> str:
    """Replace characters that the font lacks with boxes."""
    return "".join(char if ord(char) in _signs() else "□" for char in words)


@cache
def _signs() -> frozenset[int]:
    """Return the code points that the font contains."""
    from matplotlib.font_manager import findfont, get_font

    return frozenset(get_font(findfont(FONT)).get_charmap())
