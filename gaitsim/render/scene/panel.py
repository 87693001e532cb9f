"""One body's part of a picture: artists are created once, then moved."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.render.scene.altitude_scale import AltitudeScale
from gaitsim.render.scene.bodies import body, shadow
from gaitsim.render.scene.camera import DISTANCE, VIEWS, Camera, Points, axes
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.scene.ground import SHADES, fine_step, grid
from gaitsim.render.scene.labels import POINT, Labels, unit_of
from gaitsim.render.scene.shapes import discs, hull
from gaitsim.render.scene.themes import Theme, mixed

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FOOT = 1.55  # radius of a foot's mark, in those of limbs
TRAIL = 240  # pieces of the path behind a body
CENTRE = 0.5  # of the body, as a share of a panel's height


class Panel:
    """A part of a figure that shows one clip.

    Args:
        figure: to draw in, at `DPI`.
        place: left, bottom, width and height, pixels.
        clip: what to show.
        theme: its colours.
        view: one of `VIEWS`.
        scale: pixels a metre at the body.
        middle: of what is seen, from where the camera aims, (3,) m.
    """

    def __init__(
        self,
        figure: "Figure",
        place: tuple[float, float, float, float],
        clip: Clip,
        theme: Theme,
        view: str,
        scale: float,
        middle: Points,
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection
        from matplotlib.transforms import Bbox, IdentityTransform

        self.clip, self.theme, self.view = clip, theme, view
        self.scale, self.middle = scale, middle
        left, bottom, width, height = place
        self.unit = unit_of(width, height)
        self.reach = 0.75 * float(np.hypot(width, height))
        self.centre = np.array([left + width / 2, bottom + height * CENTRE])
        self.colours = theme.colours
        self._frame = Bbox.from_bounds(*place)
        self._figure, self._identity = figure, IdentityTransform()
        self._line = 1.3 * self.unit
        line = self._line * POINT

        def add(artist: Any, order: int) -> Any:
            artist.set_transform(self._identity)
            figure.add_artist(artist, clip=False)
            artist.set_clip_box(self._frame)
            artist.set_zorder(order)
            return artist

        ground = self.colours["ground"]
        shades = mixed(ground, self.colours["grid"], np.arange(1, SHADES + 1) / SHADES)
        trail = mixed(ground, self.colours["path"], np.arange(1, SHADES + 1) / SHADES)
        self.shadow = add(PolyCollection([], facecolors=theme.shadow, edgecolors="none"), 1)
        self.grid = add(PathCollection([], facecolors="none", edgecolors=shades), 2)
        self.grid.set_linewidths([0.8 * line])
        self.support = add(
            PolyCollection([], facecolors=(*self.colours["stance"], 0.16), edgecolors=theme.stance),
            3,
        )
        self.support.set_linewidths([0.8 * line])
        self.trail = add(PathCollection([], facecolors="none", edgecolors=trail), 4)
        self.trail.set_linewidths([2.2 * line])
        self.stance = add(
            PolyCollection([], facecolors=theme.stance, edgecolors=theme.limb_edge), 5
        )
        self.stance.set_linewidths([0.6 * line])
        self.swing = add(LineCollection([], colors=theme.swing, linewidths=1.8 * line), 6)
        self.body = add(PolyCollection([], joinstyle="round"), 7)
        rise = scale * float(np.cos(np.radians(VIEWS[view][1])))
        upright = self.clip.flies and rise > 0.5 * scale
        self.altitude_scale = (
            AltitudeScale(figure, place, theme, rise, self.unit) if upright else None
        )
        self.labels = Labels(figure, place, clip, theme, fine_step(scale, self.unit))

    def show(self, seconds: float, turned: float = 0.0) -> None:
        """Move everything to a moment.

        Args:
            seconds: of the clip.
            turned: angle of the camera around the body, degrees.
        """
        pose = self.clip.at(seconds)
        azimuth, elevation = VIEWS[self.view]
        camera = Camera(
            pose.aim + self.middle,
            *axes(azimuth + turned, elevation),
            distance=DISTANCE * self.clip.anatomy.span,
            scale=self.scale,
            centre=self.centre,
        )
        self._show_ground(camera, pose)
        self._show_feet(camera, pose)
        self._show_body(camera, pose)
        self.labels.set_clock(pose, seconds)

    def _show_ground(self, camera: Camera, pose: Pose) -> None:
        clip = self.clip
        ends, strength = grid(camera, clip.anatomy.span, self.reach, self.unit, clip.corners)
        self.grid.set_paths(_layers(camera, clip.grounded(ends), strength))
        trail = pose.trail if clip.flies else clip.grounded(pose.trail)
        seen = np.linalg.norm(trail - pose.aim, axis=1) * self.scale < self.reach
        since = int(np.flatnonzero(~seen)[-1]) + 1 if not seen.all() else 0
        every = np.unique(np.linspace(since, len(trail) - 1, TRAIL + 1).astype(int))
        trail = trail[every]
        pieces = np.stack([trail[:-1], trail[1:]], axis=1)
        away = np.linalg.norm(pieces.mean(axis=1) - pose.aim, axis=1) * self.scale / self.reach
        self.trail.set_paths(_layers(camera, pieces, 1 - away))
        self.shadow.set_verts(shadow(camera, clip.grounded(pose.segments), clip.anatomy))

    def _show_feet(self, camera: Camera, pose: Pose) -> None:
        clip = self.clip
        standing = clip.grounded(pose.contacts[pose.touching])
        support = clip.grounded(np.pad(hull(standing[:, :2]), ((0, 0), (0, 1))))
        self.support.set_verts([camera.project(support)[0]])
        size = FOOT * clip.anatomy.thickness
        self.stance.set_verts(list(camera.project(clip.grounded(discs(standing, size)))[0]))
        swinging, depth = camera.project(pose.contacts[~pose.touching])
        radius = 0.75 * size * camera.scale_at(depth)
        turn = np.linspace(0, 2 * np.pi, 25)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        self.swing.set_segments(list(swinging[:, None] + radius[:, None, None] * circle))

    def _show_body(self, camera: Camera, pose: Pose) -> None:
        parts = body(camera, pose.segments, self.clip.anatomy, self.colours, self._line)
        self.body.set_verts([part.outline for part in parts])
        self.body.set_facecolors(np.array([part.face for part in parts]))
        self.body.set_edgecolors(np.array([part.edge for part in parts]))
        self.body.set_linewidths([part.width * POINT for part in parts])
        if self.altitude_scale:
            at = float(camera.project(pose.middle)[0][1])
            self.altitude_scale.show(float(pose.middle[2]) + self.clip.floor, at)


def _layers(camera: Camera, pieces: Points, strength: Points) -> Sequence[Any]:
    """Return pieces of lines (pieces, 2, 3) as one path for each shade."""
    from matplotlib.path import Path

    ends, depth = camera.project(pieces)
    shade = np.round(np.clip(strength, 0, 1) * SHADES) * camera.in_front(depth).all(axis=1)
    paths = []
    for wanted in range(1, SHADES + 1):
        points = ends[shade == wanted].reshape(-1, 2)
        codes = np.full(len(points), Path.LINETO, dtype=Path.code_type)
        codes[::2] = Path.MOVETO
        paths.append(Path(points, codes))
    return paths
