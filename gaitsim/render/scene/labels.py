"""The texts of a panel, none wider than the panel."""

from bisect import bisect_left
from functools import cache
from typing import TYPE_CHECKING, Any

from gaitsim.render.scene import captions
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.scene.layout import Place
from gaitsim.render.scene.themes import Theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 64  # a power of two, so that a size in pixels is exact in inches
POINT = 72 / DPI  # points of a pixel, in which widths and letters are given
SMALLEST = 9.0  # pixels: smaller letters cannot be read
FONT = "DejaVu Sans"  # comes with matplotlib; its digits are all of one width


class Labels:
    """A panel's title, details, clock and legend.

    Args:
        figure: to write in, at `DPI`.
        place: the panel's left, bottom, width and height, pixels.
        clip: what the panel shows.
        theme: its colours.
        grid: distance between the lines on the ground, m.

    Attributes:
        still: the artists that stay as they are.
        clock: the one that changes.
    """

    def __init__(
        self, figure: "Figure", place: Place, clip: Clip, theme: Theme, grid: float
    ) -> None:
        self._figure, self._clip, self._theme = figure, clip, theme
        self.still: list[Any] = []
        left, bottom, width, height = place
        self._unit = unit_of(width, height)
        pad = 22 * self._unit
        big, small = (max(size * self._unit, SMALLEST) for size in (21, 15))
        room, top = width - 2 * pad, bottom + height - pad
        title = self._text(left + pad, top, clip.title, big, weight="bold", va="top")
        self._fit(title, room)
        under = top - 1.35 * _size(title)
        details = self._text(left + pad, under, clip.details, small, colour="faint", va="top")
        self._fit(details, room)
        self.clock = self._text(left + pad, bottom + pad, captions.longest_moment(clip), big)
        self._fit(self.clock, room)
        self.still.remove(self.clock)
        used = self._box(self.clock).width + 2 * pad
        self._legend(left + width - pad, bottom + pad, room - used, small, grid)

    def set_clock(self, pose: Pose, seconds: float) -> None:
        """Set the clock to a moment."""
        self.clock.set_text(captions.moment(self._clip, pose, seconds))

    def _legend(self, right: float, bottom: float, room: float, size: float, grid: float) -> None:
        """Write the meaning of the markers and the step of the grid, as far as there is room.

        A flying body has a scale of altitude instead: its grid varies with the altitude.
        """
        if self._clip.flies:
            return
        scale = [(f"grid {captions.step(grid)}", "")]
        feet = [("on the ground", "stance"), ("in the air", "swing")]
        for entries in [*feet, *scale], feet:
            before, at = len(self.still), right
            for words, marker in reversed(entries):
                at = self._entry(at, bottom, words, marker, size)
            if right - at <= room:
                return
            while len(self.still) > before:
                self.still.pop().remove()

    def _entry(self, right: float, bottom: float, words: str, marker: str, size: float) -> float:
        """Write an entry of the legend from the right; return where the next one can end."""
        from matplotlib.lines import Line2D
        from matplotlib.transforms import IdentityTransform

        text = self._text(right, bottom, words, size, colour="faint", ha="right")
        left = float(self._box(text).x0) - 0.6 * size
        if marker:
            filled = marker == "stance"
            colour = getattr(self._theme, marker)
            sign = Line2D(
                [left - 0.2 * size],
                [bottom + 0.36 * size],
                linestyle="none",
                marker="o",
                markersize=(0.75 if filled else 0.62) * size * POINT,
                markerfacecolor=colour if filled else "none",
                markeredgecolor=self._theme.limb_edge if filled else colour,
                markeredgewidth=(0.05 if filled else 0.15) * size * POINT,
                transform=IdentityTransform(),
            )
            self.still.append(self._figure.add_artist(sign))
            left -= 0.8 * size
        return left - 0.6 * size

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
        """Write a text of a size in pixels."""
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
        """Make a text fit: with smaller letters first, then with an ellipsis."""
        while self._box(text).width > room and _size(text) > 1.2 * SMALLEST:
            text.set_fontsize(max(_size(text) / 1.1, SMALLEST) * POINT)
        whole = text.get_text()
        if self._box(text).width <= room or len(whole) == 1:
            return

        def cut(kept: int) -> bool:
            """Keep so many letters; return whether these are still too wide."""
            text.set_text(whole[:kept].rstrip() + "…")
            return bool(self._box(text).width > room)

        cut(max(bisect_left(range(1, len(whole)), True, key=cut), 1))

    def _box(self, text: Any) -> Any:
        return text.get_window_extent(self._figure.canvas.get_renderer())  # type: ignore[attr-defined]


def unit_of(width: float, height: float) -> float:
    """Return the size of a panel relative to one of 960 × 720 pixels."""
    return max(min(width / 960, height / 720), 0.36)


def _size(text: Any) -> float:
    return float(text.get_fontsize()) / POINT


def _printable(words: str) -> str:
    """Replace characters that the font lacks with boxes."""
    return "".join(char if ord(char) in _signs() else "□" for char in words)


@cache
def _signs() -> frozenset[int]:
    """Return the code points of the font."""
    from matplotlib.font_manager import findfont, get_font

    return frozenset(get_font(findfont(FONT)).get_charmap())
