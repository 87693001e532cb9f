"""The grid of the ground in a picture."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from numpy.typing import NDArray

from gaitsim.render.scene.camera import Camera, Points
from gaitsim.render.scene.ground import SHADES
from gaitsim.render.scene.themes import Theme, mix, rgb


class Lines(Artist):
    """The lines of the grid, drawn pixel by pixel, in a quarter of the time that Matplotlib takes.

    Args:
        theme: colours of the picture.
        width: width of the lines, pixels.
    """

    def __init__(self, theme: Theme, width: float) -> None:
        super().__init__()
        shades = mix(rgb(theme.ground), rgb(theme.grid), np.arange(SHADES + 1) / SHADES)
        self._shades, self._width = (255 * shades).astype(np.float32), width
        self._ends, self._colours = np.empty((0, 2, 2)), np.empty((0, 3), dtype=np.float32)

    def show(self, camera: Camera, pieces: Points, strength: Points) -> None:
        """Move the lines.

        Args:
            camera: camera of the picture.
            pieces: both ends of each piece, (pieces, 2, 3) m.
            strength: strength of each piece, 0 to 1, (pieces,).
        """
        ends, shade = shaded(camera, pieces, strength)
        order = np.argsort(shade, kind="stable")[np.count_nonzero(shade == 0) :]
        self._ends, self._colours = ends[order], self._shades[shade[order]]

    def draw(self, renderer: Any) -> None:
        """Draw the lines."""
        from gaitsim.render.scene.kernels import rule

        rule(np.asarray(renderer.buffer_rgba()), self._ends, self._colours, self._width)


def shaded(camera: Camera, pieces: Points, strength: Points) -> tuple[Points, NDArray[np.intp]]:
    """Project pieces of lines.

    Args:
        camera: camera of the picture.
        pieces: both ends of each piece, (pieces, 2, 3) m.
        strength: strength of each piece, 0 to 1, (pieces,).

    Returns:
        Both ends of each piece, (pieces, 2, 2) pixels, and its shade, (pieces,); 0 hides it.
    """
    ends, depth = camera.project(pieces)
    shade = np.round(np.clip(strength, 0, 1) * SHADES) * camera.in_front(depth).all(axis=1)
    return ends, shade.astype(np.intp)
