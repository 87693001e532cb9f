"""The altitude scale beside a flying body, which moves as the body climbs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.render.plots.labels import format_number
from gaitsim.render.scene.ground import steps
from gaitsim.render.scene.labels import MIN_LETTERS, POINT, text_path
from gaitsim.render.scene.themes import Theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MIN_NUMBER_GAP = 70.0  # minimum pixels between numbers
DIVISIONS = 5  # divisions between two numbers


class AltitudeScale:
    """A ruler at the right edge of the picture, at the scale of the bodies.

    Args:
        figure: figure to draw in.
        size: width and height of the picture, pixels.
        theme: colours of the picture.
        colours: colour of each body's pointer.
        scale: pixels per metre of altitude.
        unit: size of the picture; see `relative_size`.
    """

    def __init__(
        self,
        figure: "Figure",
        size: tuple[int, int],
        theme: Theme,
        colours: Sequence[str],
        scale: float,
        unit: float,
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection
        from matplotlib.transforms import IdentityTransform

        width, height = size
        self._right = width - 22 * unit
        # Between the title and the clock.
        self._low, self._high = 0.16 * height, 0.84 * height
        self._scale, self._unit = scale, unit
        self._step = steps(MIN_NUMBER_GAP * unit / scale)[0]
        self._size = max(14 * unit, MIN_LETTERS)
        self._ticks = LineCollection([], colors=theme.faint, linewidths=1.2 * unit * POINT)
        self._numbers = PathCollection([], facecolors=theme.faint, edgecolors="none")
        self._pointer = PolyCollection([], facecolors=colours, edgecolors="none")
        for artist in (self._ticks, self._numbers, self._pointer):
            artist.set_transform(IdentityTransform())
            artist.set_zorder(8)
            figure.add_artist(artist)

    def show(self, altitudes: Sequence[float], altitude: float, at: float) -> None:
        """Move the ruler.

        Args:
            altitudes: altitudes of the bodies, m.
            altitude: altitude shown at the height `at` in the picture, m.
            at: height in the picture, pixels.
        """
        at = float(np.clip(at, self._low, self._high))
        fine = self._step / DIVISIONS
        first = int(np.ceil(altitude / fine + (self._low - at) / (fine * self._scale)))
        last = int(np.floor(altitude / fine + (self._high - at) / (fine * self._scale)))
        number = np.arange(first, last + 1)
        y = at + (number * fine - altitude) * self._scale
        long = number % DIVISIONS == 0
        length = np.where(long, 14, 7) * self._unit
        ticks = np.empty((len(number), 2, 2))
        ticks[:, 0, 0], ticks[:, 1, 0] = self._right - length, self._right
        ticks[..., 1] = y[:, None]
        line = np.array([[[self._right, self._low], [self._right, self._high]]])
        self._ticks.set_segments([*line, *ticks])
        right = self._right - 22 * self._unit
        self._numbers.set_paths(
            [
                text_path(
                    f"{format_number(value)} m",
                    self._size,
                    (right, height - 0.36 * self._size),
                    1.0,
                )
                for value, height in zip(number[long] * fine, y[long], strict=True)
            ]
        )
        heights = at + (np.array(altitudes) - altitude) * self._scale
        heights = np.clip(heights, self._low, self._high)[:, None, None]
        wide = 9 * self._unit
        tip = np.array([[0.0, 0.0], [1.4 * wide, wide], [1.4 * wide, -wide]])
        tip[:, 0] += self._right + 2 * self._unit
        self._pointer.set_verts([*(tip + heights * np.array([0.0, 1.0]))])
