"""One body's part of a picture: artists made once, then moved from moment to moment."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.export.scene.camera import DISTANCE, VIEWS, Camera, axes
from gaitsim.export.scene.ground import SHADES, fine_step, grid, shaded
from gaitsim.export.scene.lettering import POINT, Lettering, unit_of
from gaitsim.export.scene.shapes import capsules, discs, hull
from gaitsim.export.scene.take import Pose, Take
from gaitsim.export.scene.themes import Theme, mixed, rgb

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Points = NDArray[np.float64]

TRAIL = 240  # pieces of the path behind a body
FOG = 0.3  # how much the far side of a body takes of the background


class Panel:
    """A part of a figure that shows one take.

    Args:
        figure: to draw in, at `DPI`.
        place: left, bottom, width and height, pixels.
        take: what to show.
        theme: its colours.
        view: one of `VIEWS`.
        scale: pixels a metre at the body.
        middle: of what is seen, from where the camera aims, (3,) m.
    """

    def __init__(
        self,
        figure: "Figure",
        place: tuple[float, float, float, float],
        take: Take,
        theme: Theme,
        view: str,
        scale: float,
        middle: Points,
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection
        from matplotlib.transforms import Bbox, IdentityTransform

        self.take, self.theme, self.view = take, theme, view
        self.scale, self.middle = scale, middle
        left, bottom, width, height = place
        self.unit = unit_of(width, height)
        self.reach = 0.75 * float(np.hypot(width, height))
        self.centre = np.array([left + width / 2, bottom + height * CENTRE])
        self.colours = {name: rgb(colour) for name, colour in vars(theme).items()}
        self._clip = Bbox.from_bounds(*place)
        self._figure, self._identity = figure, IdentityTransform()
        line = 1.3 * self.unit * POINT

        def add(artist: Any, order: int) -> Any:
            artist.set_transform(self._identity)
            figure.add_artist(artist, clip=False)
            artist.set_clip_box(self._clip)
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
        self._line = line
        self.lettering = Lettering(figure, place, take, theme, fine_step(scale, self.unit))

    def show(self, seconds: float, turned: float = 0.0) -> None:
        """Move everything to a moment.

        Args:
            seconds: of the take.
            turned: how far the camera has gone around the body, degrees.
        """
        pose = self.take.at(seconds)
        azimuth, elevation = VIEWS[self.view]
        camera = Camera(
            pose.aim + self.middle,
            *axes(azimuth + turned, elevation),
            distance=DISTANCE * self.take.anatomy.span,
            scale=self.scale,
            centre=self.centre,
        )
        self._show_ground(camera, pose)
        self._show_feet(camera, pose)
        self._show_body(camera, pose)
        self.lettering.tell(pose, seconds)

    def _show_ground(self, camera: Camera, pose: Pose) -> None:
        ends, strength = grid(camera, self.take.anatomy.span, self.reach, self.unit)
        self.grid.set_paths(_layers(camera, ends, strength))
        trail = pose.trail.copy()
        if not self.take.flies:
            trail[:, 2] = 0.0
        seen = np.linalg.norm(trail - pose.aim, axis=1) * self.scale < self.reach
        since = int(np.flatnonzero(~seen)[-1]) + 1 if not seen.all() else 0
        every = np.unique(np.linspace(since, len(trail) - 1, TRAIL + 1).astype(int))
        trail = trail[every]
        pieces = np.stack([trail[:-1], trail[1:]], axis=1)
        away = np.linalg.norm(pieces.mean(axis=1) - pose.aim, axis=1) * self.scale / self.reach
        self.trail.set_paths(_layers(camera, pieces, 1 - away))
        shadow = pose.segments.copy()
        shadow[..., 2] = 0.0
        look = self.take.anatomy
        outlines = list(_capsules(camera, shadow[look.limbs], look.radii)[0])
        for plate in look.plates:
            outlines.append(camera.project(shadow[list(plate), 0])[0])
        self.shadow.set_verts(outlines)

    def _show_feet(self, camera: Camera, pose: Pose) -> None:
        standing = pose.contacts[pose.touching].copy()
        standing[:, 2] = 0.0
        self.support.set_verts([camera.project(_on_ground(hull(standing[:, :2])))[0]])
        size = 0.028 * self.take.anatomy.span
        self.stance.set_verts(list(camera.project(discs(standing, size))[0]))
        swinging, depth = camera.project(pose.contacts[~pose.touching])
        radius = 0.75 * size * camera.scale_at(depth)
        turn = np.linspace(0, 2 * np.pi, 25)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        self.swing.set_segments(list(swinging[:, None] + radius[:, None, None] * circle))

    def _show_body(self, camera: Camera, pose: Pose) -> None:
        """Limbs and plates, the farthest first."""
        look, colours = self.take.anatomy, self.colours
        ground = colours["ground"]
        drawn: list[tuple[float, int, list[tuple[Points, Points, Points, float]]]] = []
        segments = pose.segments[look.limbs]
        sides, depth = _capsules(camera, segments, look.radii)
        lights, _ = _capsules(camera, segments, look.radii, 0.42, 0.36)
        fog = self._fog(camera, depth)
        trunk = look.trunks[:, None]
        side, light = (
            mixed(np.where(trunk, colours[f"body{of}"], colours[f"limb{of}"]), ground, fog)
            for of in ("", "_light")
        )
        edge = mixed(colours["limb_edge"], ground, fog)
        # Limbs begin inside a trunk, whose middle line is where they are hinged.
        depth = depth - look.span * look.trunks
        for i in range(len(segments)):
            drawn.append(
                (
                    float(depth[i]),
                    i,
                    [(sides[i], side[i], edge[i], 1.1), (lights[i], light[i], light[i], 0.0)],
                )
            )
        for place, (plate, radius) in enumerate(
            zip(look.plates, look.plate_radii, strict=True), len(segments)
        ):
            drawn.append(self._plate(camera, pose.segments[list(plate), 0], radius, place))
        drawn.sort(key=lambda one: (-one[0], one[1]))
        parts = [part for _, _, parts in drawn for part in parts]
        self.body.set_verts([part[0] for part in parts])
        self.body.set_facecolors([part[1] for part in parts])
        self.body.set_edgecolors([part[2] for part in parts])
        self.body.set_linewidths([part[3] * self._line for part in parts])

    def _plate(
        self, camera: Camera, corners: Points, radius: float, place: int
    ) -> tuple[float, int, list[tuple[Points, Points, Points, float]]]:
        """A slab of rounded corners."""
        normal = np.cross(corners[1] - corners[0], corners[-1] - corners[0])
        normal /= max(float(np.linalg.norm(normal)), 1e-12)
        if normal @ camera.ahead > 0:
            normal = -normal
        front, depth = camera.project(corners + radius * normal)
        back, _ = camera.project(corners - radius * normal)
        fog = self._fog(camera, depth.mean())
        side, light, edge = (
            mixed(self.colours[name], self.colours["ground"], fog)
            for name in ("body", "body_light", "limb_edge")
        )
        around = hull(np.concatenate([front, back]))
        rounding = 2 * radius * self.scale * POINT / self._line
        return (
            float(depth.mean()),
            place,
            [
                (around, edge, edge, rounding + 2.2),
                (around, side, side, rounding),
                (front, light, light, 0.3 * rounding),
            ],
        )

    def _fog(self, camera: Camera, depth: Any) -> Any:
        span = self.take.anatomy.span
        return FOG * np.clip((depth - camera.distance) / span + 0.5, 0.0, 1.0)


CENTRE = 0.5  # of the body, as a share of a panel's height


def _on_ground(points: Points) -> Points:
    return np.concatenate([points, np.zeros((len(points), 1))], axis=1)


def _capsules(
    camera: Camera, segments: Points, radii: Points, share: float = 1.0, lift: float = 0.0
) -> tuple[Points, Points]:
    """Limbs in the picture, thinner and nearer to the light by shares of their radii."""
    ends, depth = camera.project(segments)
    pixels = radii * camera.scale_at(depth)
    along = ends[:, 1] - ends[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across *= np.where(across[:, 1:] < 0, -1.0, 1.0)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    ends = ends + lift * pixels[..., None] * across[:, None]
    return capsules(ends, share * pixels), depth.mean(axis=1)


def _layers(camera: Camera, pieces: Points, strength: Points) -> Sequence[Any]:
    """Pieces of lines (pieces, 2, 3) as one path a shade."""
    from matplotlib.path import Path

    ends, depth = camera.project(pieces)
    shade = np.where(camera.in_front(depth).all(axis=1), shaded(strength), 0)
    paths = []
    for wanted in range(1, SHADES + 1):
        points = ends[shade == wanted].reshape(-1, 2)
        codes = np.full(len(points), Path.LINETO, dtype=Path.code_type)
        codes[::2] = Path.MOVETO
        paths.append(Path(points, codes))
    return paths
