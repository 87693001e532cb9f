"""Bodies in three dimensions: a still of one, or picture after picture of several."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.export.scene.camera import VIEWS, fitting
from gaitsim.export.scene.layout import tiles
from gaitsim.export.scene.take import Take
from gaitsim.export.scene.themes import THEMES

__all__ = ["THEMES", "VIEWS", "Picture", "Scene", "Take", "draw"]

Picture = NDArray[np.uint8]
"""(height, width, 4): red, green, blue, opacity, the top row first."""

FILLED = 0.56, 0.52  # shares of a panel's width and height that a body may fill


class Scene:
    """Bodies side by side, seen from one side and at one scale.

    Args:
        takes: what to show, a panel each.
        size: width and height, pixels.
        view: one of `VIEWS`.
        theme: one of `THEMES`.
    """

    def __init__(self, takes: Sequence[Take], size: tuple[int, int], view: str, theme: str) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        from gaitsim.export.scene.lettering import DPI
        from gaitsim.export.scene.panel import Panel

        width, height = size
        colours = THEMES[theme]
        figure = Figure((width / DPI, height / DPI), dpi=DPI, facecolor=colours.ground)
        self._canvas: Any = FigureCanvasAgg(figure)
        places = tiles(len(takes), width, height)
        box = np.concatenate([take.box for take in takes])
        _, _, wide, tall = places[0]
        scale, middle = fitting(box, view, FILLED[0] * wide, FILLED[1] * tall)
        self.panels = [
            Panel(figure, place, take, colours, view, scale, middle)
            for place, take in zip(places, takes, strict=True)
        ]
        self._bake()
        self.seconds = max(take.seconds for take in takes)

    def _bake(self) -> None:
        """Replace texts that stay as they are by pictures of them: a text takes 1 to 3 ms."""
        figure, height = self._canvas.figure, self._canvas.get_width_height()[1]
        figure.patch.set_alpha(0)
        for panel in self.panels:
            panel.lettering.clock.set_visible(False)
        self._canvas.draw()
        drawn = np.array(self._canvas.buffer_rgba())
        for panel in self.panels:
            for artist in panel.lettering.still:
                box = artist.get_window_extent(self._canvas.get_renderer())
                left, bottom = max(int(box.x0) - 2, 0), max(int(box.y0) - 2, 0)
                top, right = int(box.y1) + 3, int(box.x1) + 3
                part = drawn[max(height - top, 0) : height - bottom, left:right]
                artist.remove()
                if part.size:
                    figure.figimage(part, left, bottom, zorder=9)
            panel.lettering.clock.set_visible(True)
        figure.patch.set_alpha(1)

    def draw(self, seconds: float, turned: float = 0.0) -> Picture:
        """The picture at a moment.

        Args:
            seconds: since the takes began; one that has ended keeps its last pose.
            turned: how far the camera has gone around the bodies, degrees.
        """
        for panel in self.panels:
            panel.show(seconds, turned)
        self._canvas.draw()
        return np.array(self._canvas.buffer_rgba())


def draw(
    skeleton: Skeleton,
    seconds: float = 0.0,
    *,
    size: tuple[int, int] = (1280, 720),
    view: str = "iso",
    theme: str = "light",
    title: str = "",
    details: str = "",
) -> Picture:
    """A still of one body, such as for a page of documentation.

    Args:
        skeleton: its motion.
        seconds: at which moment of it.
        size: width and height, pixels.
        view: one of `VIEWS`.
        theme: one of `THEMES`.
        title: a first line in it.
        details: a second one.
    """
    return Scene([Take(skeleton, title, details)], size, view, theme).draw(seconds)
