"""Render one or several bodies in three dimensions."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.render.scene.camera import VIEWS, view_angles
from gaitsim.render.scene.clip import Clip, Race
from gaitsim.render.scene.themes import THEMES, SceneTheme

__all__ = ["THEMES", "VIEWS", "Clip", "Picture", "Scene", "draw"]

Picture = NDArray[np.uint8]
"""(height, width, 4): red, green, blue and opacity, from the top row down."""

Stamp = tuple[tuple[slice, slice], NDArray[np.uint16], NDArray[np.uint16]]
"""An overlay: its place in each picture, its colours times opacity, and its transparency."""


class Scene:
    """One body, or several that race in lanes on one ground, from one viewpoint.

    Args:
        clips: clips to show.
        size: width and height, pixels.
        view: name of a view in `VIEWS`.
        theme: name of a theme in `THEMES`.
        heading: first and second line of text; None takes the title and details of the first clip.
        leader: index of the clip that stays visible when the bodies are too far apart to show all.
    """

    def __init__(
        self,
        clips: Sequence[Clip],
        size: tuple[int, int],
        view: str,
        theme: str,
        heading: tuple[str, str] | None = None,
        leader: int = -1,
    ) -> None:
        from matplotlib import style

        if view == "top" and all(clip.planar for clip in clips):
            view = "side"
        race = Race(clips, leader, view_angles(view, len(clips) > 1))
        self.heading = heading or (clips[0].title, clips[0].details)
        # Ignore the user's Matplotlib settings.
        with style.context({}, after_reset=True):
            self._build(race, size, view, THEMES[theme])
        self.seconds = race.seconds

    def _build(self, race: Race, size: tuple[int, int], view: str, theme: SceneTheme) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        from gaitsim.render.scene.labels import DPI
        from gaitsim.render.scene.world import World

        width, height = size
        figure = Figure((width / DPI, height / DPI), dpi=DPI, facecolor=theme.ground)
        self._canvas: Any = FigureCanvasAgg(figure)
        self.world = World(figure, size, race, theme, view, self.heading)
        self._still = list(self._stamps())
        self._artists = [one for one in figure.get_children() if one is not figure.patch]
        self._renderer = self._canvas.renderer
        self._renderer.clear()
        figure.patch.draw(self._renderer)
        self._background = self._renderer.copy_from_bbox(figure.bbox)

    def _stamps(self) -> Iterator[Stamp]:
        """Yield the labels that never change as overlays, which saves 1 to 3 ms for each label."""
        figure, height = self._canvas.figure, self._canvas.get_width_height()[1]
        figure.patch.set_alpha(0)
        self._canvas.draw()
        drawn = np.array(self._canvas.buffer_rgba())
        for artist in self.world.labels.still:
            box = artist.get_window_extent(self._canvas.get_renderer())
            top, bottom = (max(height - int(y), 0) for y in (box.y1 + 3, box.y0 - 2))
            place = (slice(top, bottom), slice(max(int(box.x0) - 2, 0), int(box.x1) + 3))
            artist.remove()
            opacity = drawn[place][..., 3:].astype(np.uint16)
            yield place, drawn[place][..., :3] * opacity, 255 - opacity
        figure.patch.set_alpha(1)

    def draw(self, seconds: float, turned: float = 0.0) -> Picture:
        """Return the picture at a moment.

        Args:
            seconds: time since the clips began; a clip that has ended keeps its last pose.
            turned: angle of the camera around the bodies, degrees.
        """
        self.world.show(seconds, turned)
        self._renderer.restore_region(self._background)
        # In the order in which the figure would draw them.
        for artist in sorted(self._artists, key=lambda artist: artist.zorder):
            if not hasattr(artist, "get_paths") or artist.get_paths():  # an empty one takes 0.3 ms
                artist.draw(self._renderer)
        picture = np.array(self._renderer.buffer_rgba())
        for place, ink, clear in self._still:
            part = picture[place][..., :3]
            part[:] = (part * clear + ink + 127) // 255
        return picture


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
    """Return a still of one body, for example for documentation.

    Args:
        skeleton: motion of the body.
        seconds: time since the motion began.
        size: width and height, pixels.
        view: name of a view in `VIEWS`.
        theme: name of a theme in `THEMES`.
        title: first line of text.
        details: second line of text.
    """
    return Scene([Clip(skeleton, title, details)], size, view, theme).draw(seconds)
