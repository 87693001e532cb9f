"""The figure at the beginning of a video."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.render.scene import THEMES, Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.render.plots.style import Theme

    Draw = Callable[[Theme, tuple[float, float]], Figure]
    """A function that draws a figure in a theme and a size (width and height in inches)."""

MARGIN = 0.05  # margin around the figure, as a share of the smaller side
_LETTERS = 95.0  # dots per inch of the figure, for legible letters
_WIDTHS = 3.4, 5.6  # minimum and maximum width of the figure in inches, so that its labels fit


def figure_picture(draw: "Draw", size: tuple[int, int], theme: str) -> Picture:
    """Draw a figure in the size (width and height in pixels) and the colours of a video."""
    from io import BytesIO

    from matplotlib.image import imread

    from gaitsim.render.plots.style import THEMES as PLOT_THEMES
    from gaitsim.render.plots.style import picture

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
