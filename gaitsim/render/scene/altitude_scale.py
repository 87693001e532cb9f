"""The scale of altitude beside a flying body, which moves as the body climbs."""

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.render.plots.labels import numeral
from gaitsim.render.scene.ground import steps
from gaitsim.render.scene.labels import FONT, POINT, SMALLEST
from gaitsim.render.scene.layout import Place
from gaitsim.render.scene.themes import Theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

APART = 70.0  # pixels between numbers, at least
PARTS = 5  # between two numbers


class AltitudeScale:
    """A ruler at the right edge of a panel, at the scale of the body.

    Args:
        figure: to draw in.
        place: the panel's left, bottom, width and height, pixels.
        theme: its colours.
        scale: pixels a metre of altitude.
        unit: see `unit_of`.
    """

    def __init__(
        self, figure: "Figure", place: Place, theme: Theme, scale: float, unit: float
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection
        from matplotlib.transforms import IdentityTransform

        left, bottom, width, height = place
        self._right = left + width - 22 * unit
        # Between the title and the clock.
        self._low, self._high = bottom + 0.16 * height, bottom + 0.84 * height
        self._scale, self._unit = scale, unit
        self._step = steps(APART * unit / scale)[0]
        self._size = max(14 * unit, SMALLEST)
        self._ticks = LineCollection([], colors=theme.faint, linewidths=1.2 * unit * POINT)
        self._numbers = PathCollection([], facecolors=theme.faint, edgecolors="none")
        self._pointer = PolyCollection([], facecolors=theme.path, edgecolors="none")
        for artist in (self._ticks, self._numbers, self._pointer):
            artist.set_transform(IdentityTransform())
            artist.set_zorder(8)
            figure.add_artist(artist)

    def show(self, altitude: float, at: float) -> None:
        """Move the ruler so that an altitude, m, is at a height in the picture, pixels."""
        from matplotlib.path import Path

        at = float(np.clip(at, self._low, self._high))
        fine = self._step / PARTS
        first = int(np.ceil(altitude / fine + (self._low - at) / (fine * self._scale)))
        last = int(np.floor(altitude / fine + (self._high - at) / (fine * self._scale)))
        number = np.arange(first, last + 1)
        y = at + (number * fine - altitude) * self._scale
        long = number % PARTS == 0
        length = np.where(long, 14, 7) * self._unit
        ticks = np.empty((len(number), 2, 2))
        ticks[:, 0, 0], ticks[:, 1, 0] = self._right - length, self._right
        ticks[..., 1] = y[:, None]
        line = np.array([[[self._right, self._low], [self._right, self._high]]])
        self._ticks.set_segments([*line, *ticks])
        words = []
        for value, height in zip(number[long] * fine, y[long], strict=True):
            glyphs = _glyphs(f"{numeral(value)} m")
            vertices = glyphs.vertices * self._size / 100
            right = self._right - 22 * self._unit - vertices[:, 0].max()
            place = np.array([right, height - 0.36 * self._size])
            words.append(Path(vertices + place, glyphs.codes))
        self._numbers.set_paths(words)
        wide = 9 * self._unit
        tip = self._right + 2 * self._unit
        self._pointer.set_verts(
            [np.array([[tip, at], [tip + 1.4 * wide, at + wide], [tip + 1.4 * wide, at - wide]])]
        )


@cache
def _glyphs(words: str) -> Any:
    """Return a text as a path of 100 pixels; drawing it takes a tenth of the time of a text."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    return TextPath((0, 0), words, size=100, prop=FontProperties(family=FONT))
