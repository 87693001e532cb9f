"""Artists that draw pixels: the solids of a body, outlined and shaded, and the ground's grid."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from numpy.typing import NDArray

from gaitsim.render.colours import LEFT, MIDDLE, RIGHT, is_damaged, sides
from gaitsim.render.scene.bodies import EDGE, FOG, LIGHT
from gaitsim.render.scene.camera import Camera, Points
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.scene.ground import SHADES
from gaitsim.render.scene.raster import raster, shades_of
from gaitsim.render.scene.solids import FINE, Drawn, outlines
from gaitsim.render.scene.themes import Colour, SceneTheme, mix, rgb


class GridLines(Artist):
    """The lines of the grid, drawn pixel by pixel, in a quarter of the time that Matplotlib takes.

    Args:
        theme: colours of the picture.
        width: width of the lines, pixels.
    """

    def __init__(self, theme: SceneTheme, width: float) -> None:
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


TINT = 0.4  # share of the side's colour in a leg
MARKED = 0.85  # share of the side's colour in a foot on the ground


class Pixels(Artist):
    """The solids of a body as an image.

    Args:
        clip: the body in motion.
        theme: colours of the picture.
        own: dark and light colour of the trunk.
        damaged: dark and light colour of damaged parts.
        line: width of a line, pixels.
        picture: width and height of the picture, pixels.
    """

    def __init__(
        self,
        clip: Clip,
        theme: SceneTheme,
        own: tuple[Colour, Colour],
        damaged: tuple[Colour, Colour],
        line: float,
        picture: tuple[int, int],
    ) -> None:
        super().__init__()
        self._clip, self._picture = clip, picture
        self._width = max(round(FINE * EDGE * line), 1)
        self._light = LIGHT / np.linalg.norm(LIGHT)
        self._ground, self._ink = rgb(theme.ground), rgb(theme.limb_edge)
        side = sides(tuple(solid.name for solid in clip.skeleton.solids))
        tint = {LEFT: rgb(theme.left), RIGHT: rgb(theme.right)}
        limb = rgb(theme.limb), rgb(theme.limb_light)
        colours = [own if one == MIDDLE else _tint(limb, tint[one], TINT) for one in side.tolist()]
        self._usual = np.array(colours).swapaxes(0, 1)
        middle = rgb(theme.middle)
        feet = sides(clip.skeleton.contact_names or ("",) * len(clip.at(0).contacts))
        marked = [_tint(limb, tint.get(one, middle), MARKED) for one in feet.tolist()]
        names = [solid.name for solid in clip.skeleton.solids]
        self._damaged = is_damaged(names, clip.skeleton.damaged)
        self._usual[:, self._damaged] = np.stack(damaged)[:, None]
        self._marked = np.array(marked).reshape(-1, 2, 3).swapaxes(0, 1)
        self._feet = [np.flatnonzero(np.equal(names, names[solid])) for solid in clip.foot_solids]
        self._image: tuple[Drawn, NDArray[np.float32]] | None = None

    def show(self, camera: Camera, pose: Pose) -> None:
        """Move the solids to a pose."""
        surfaces = self._clip.surfaces
        drawn = raster(camera, surfaces, pose.solids, self._light, self._picture, self._width)
        if drawn is None:
            self._image = None
            return
        _, depth = camera.project(pose.solids[:, :3])
        _, middle = camera.project(self._clip.points(pose).mean(axis=0))
        fog = FOG * np.clip((depth - middle) / self._clip.anatomy.span + 0.5, 0, 1)
        colours = self._usual.copy()
        for foot in np.flatnonzero(pose.touching):
            colours[:, self._feet[foot]] = self._marked[:, foot, None]
        colours[:, self._damaged] = self._usual[:, self._damaged]
        dark, bright, ink = (mix(one, self._ground, fog) for one in (*colours, self._ink))
        shades = 255 * shades_of(dark, bright, ink).reshape(-1, 3)
        self._image = drawn, shades.astype(np.float32)

    def shadow(self, camera: Camera, pose: Pose) -> Points:
        """Return the outlines of the shadow of each solid under light from above."""
        surfaces = self._clip.surfaces
        flat, _ = camera.project(self._clip.on_ground(surfaces.points_at(pose.solids)))
        return outlines(flat, surfaces.starts)

    def draw(self, renderer: Any) -> None:
        """Draw the image."""
        from gaitsim.render.scene.kernels import blend

        if self._image:
            blend(*self._image, self._width, np.asarray(renderer.buffer_rgba()))


def _tint(limb: tuple[Colour, Colour], colour: Colour, share: float) -> tuple[Colour, Colour]:
    """Mix the dark and the light colour of a limb with a share of another colour."""
    return mix(limb[0], colour, share), mix(limb[1], colour, share)
