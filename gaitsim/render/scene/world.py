"""The ground and the bodies on it, seen by one camera; artists are created once and then moved."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.render.colours import LEFT, MIDDLE, RIGHT, is_damaged, sides
from gaitsim.render.scene.bodies import body, shadow
from gaitsim.render.scene.camera import DISTANCE, Camera, Points, axes, fit_box, view_angles
from gaitsim.render.scene.clip import Clip, Pose, Race
from gaitsim.render.scene.ground import SHADES, fine_step, grid
from gaitsim.render.scene.labels import (
    MIN_LETTERS,
    POINT,
    ROW,
    Labels,
    relative_size,
    small_letters,
    text_path,
)
from gaitsim.render.scene.pixels import GridLines, Pixels, shaded
from gaitsim.render.scene.solids import discs, hull
from gaitsim.render.scene.themes import SceneTheme, mix, rgb

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TRAIL = 240  # number of pieces of the path behind a body
_CROSS = np.array([[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]])
_CIRCLE = np.linspace(0, 2 * np.pi, 25)
_ARROW = np.array([[0, -2], [9, -2], [9, -5], [15, 0], [9, 5], [9, 2], [0, 2]]) / 15
ARROW, AHEAD = 0.2, 0.1  # length of the arrow to the front and its distance, in sizes of the body


class Runner:
    """A body with its feet, shadow and path, and a tag in a race.

    Args:
        add: function that adds an artist to the picture, with its drawing order.
        clip: the body in motion.
        theme: colours of the picture.
        colour: colour of the body.
        unit: size of the picture; see `relative_size`.
        picture: width and height of the picture, pixels.
    """

    def __init__(
        self,
        add: Callable[[Any, int], Any],
        clip: Clip,
        theme: SceneTheme,
        colour: str,
        unit: float,
        picture: tuple[int, int],
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection

        self.clip, self._picture = clip, np.array(picture)
        self._line, self._size = 1.3 * unit, max(15 * unit, MIN_LETTERS)
        line = self._line * POINT
        own, ground = rgb(colour), rgb(theme.ground)
        names = ("ground", "limb", "limb_light", "limb_edge")
        self._colours = {name: rgb(getattr(theme, name)) for name in names}
        self._colours["body"] = mix(own, rgb("#000000"), 0.2)
        self._colours["body_light"] = mix(own, rgb("#ffffff"), 0.3)
        self._colours["damaged"] = rgb(theme.damaged)
        self._colours["damaged_light"] = mix(rgb(theme.damaged), rgb("#ffffff"), 0.3)
        shades = mix(ground, own, np.arange(1, SHADES + 1) / SHADES)
        self.shadow = add(PolyCollection([], facecolors=theme.shadow, edgecolors="none"), 1)
        self.support = add(
            PolyCollection([], facecolors=(*rgb(theme.ink), 0.09), edgecolors=theme.faint), 3
        )
        self.support.set_linewidths([0.8 * line])
        self.trail = add(PathCollection([], facecolors="none", edgecolors=shades), 4)
        self.trail.set_linewidths([2.2 * line])
        self.stance = add(PolyCollection([], edgecolors=theme.limb_edge), 5)
        self.stance.set_linewidths([0.6 * line])
        self.swing = add(LineCollection([], linewidths=1.8 * line), 6)
        self.lost = add(LineCollection([], colors=theme.damaged, linewidths=2.6 * line), 8)
        self.pixels = None
        if clip.skeleton.solids:
            trunk = self._colours["body"], self._colours["body_light"]
            damaged = self._colours["damaged"], self._colours["damaged_light"]
            self.pixels = Pixels(clip, theme, trunk, damaged, self._line, picture)
        self.body = add(self.pixels or PolyCollection([], joinstyle="round"), 7)
        self.tag = add(PathCollection([], facecolors=theme.ink, edgecolors="none"), 8)
        self.names = add(PathCollection([], facecolors=theme.ink, edgecolors="none"), 8)
        if clip.named:
            self.front = add(PolyCollection([], facecolors=theme.ink, edgecolors="none"), 4)
            self.pins = add(PolyCollection([], facecolors="#ffffff", edgecolors=theme.ink), 8)
            self.pins.set_linewidths([1.5 * line])
        feet = len(clip.skeleton.contact_names) or clip.at(0).contacts.shape[0]
        colours = {MIDDLE: theme.middle, LEFT: theme.left, RIGHT: theme.right}
        side = sides(clip.skeleton.contact_names or ("",) * feet)
        self._lost = is_damaged(clip.skeleton.contact_names or ("",) * feet, clip.skeleton.damaged)
        self._feet = np.array([rgb(colours[one]) for one in side.tolist()]).reshape(-1, 3)

    def show(self, camera: Camera, pose: Pose, reach: float, place: int) -> None:
        """Move everything to a pose.

        Args:
            camera: camera of the picture.
            pose: pose of the body.
            reach: radius around the aim of the camera in which the path is drawn, pixels.
            place: rank of the body by distance, 0 for the farthest.
        """
        clip = self.clip
        for step, artist in enumerate((self.stance, self.swing, self.body)):
            artist.set_zorder(5 + (place + step / 3) / 100)
        self._show_trail(camera, pose, reach)
        self._show_feet(camera, pose)
        if clip.tag:
            self._show_tag(camera, pose)
        if self.pixels:
            self.shadow.set_verts(self.pixels.shadow(camera, pose))
            self.pixels.show(camera, pose)
            return
        self.shadow.set_verts(shadow(camera, clip.on_ground(pose.segments), clip.anatomy))
        parts = body(camera, pose.segments, clip.anatomy, self._colours, self._line)
        self.body.set_verts([part.outline for part in parts])
        self.body.set_facecolors(np.array([part.face for part in parts]))
        self.body.set_edgecolors(np.array([part.edge for part in parts]))
        self.body.set_linewidths([part.width * POINT for part in parts])

    def _show_tag(self, camera: Camera, pose: Pose) -> None:
        """Write the tag above the body, or with an arrow if the body is outside the picture."""
        places, _ = camera.project(self.clip.points(pose))
        low, high = places.min(axis=0), places.max(axis=0)
        at = np.array([(low[0] + high[0]) / 2, high[1] + 0.5 * self._size])
        outside = [low[0] > self._picture[0], high[1] < 0, high[0] < 0, low[1] > self._picture[1]]
        arrow = next((arrow for arrow, out in zip("→↓←↑", outside, strict=True) if out), "")
        edge = 2.5 * self._size
        across, above = np.clip(at, edge, self._picture - edge).tolist()
        self.tag.set_paths([text_path(arrow + self.clip.tag, self._size, (across, above), 0.5)])

    def _show_names(self, camera: Camera, pose: Pose) -> None:
        """Write the name of each foot on the side that faces away from the body.

        An arrow on the ground points to the front, and circles mark the clip's pins.
        """
        places, _ = camera.project(pose.contacts)
        if not len(pose.contacts):
            return
        middle, _ = camera.project(pose.contacts.mean(axis=0))
        away = places - middle
        away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
        letters = 1.25 * self._size
        places += (self.clip.mark * camera.scale + 1.1 * letters) * away - (0, 0.36 * letters)
        nose, span = self.clip.points(pose)[:, 0].max(), self.clip.anatomy.span
        start = np.array([nose + AHEAD * span, pose.contacts[:, 1].mean(), 0.0])
        arrow = start + ARROW * span * np.pad(_ARROW, ((0, 0), (0, 1)))
        tip = start + np.array([1.6 * ARROW * span, 0.0, 0.0])
        self.front.set_verts([camera.project(self.clip.on_ground(arrow))[0]])
        places = np.vstack([places, camera.project(self.clip.on_ground(tip[None]))[0]])
        if self.clip.pins is not None:
            circle = 0.35 * letters * np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)
            self.pins.set_verts(camera.project(self.clip.pins)[0][:, None] + circle)
        names = zip((*self.clip.skeleton.contact_names, "front"), places.tolist(), strict=False)
        self.names.set_paths([text_path(name, letters, (x, y), 0.5) for name, (x, y) in names])

    def _show_trail(self, camera: Camera, pose: Pose, reach: float) -> None:
        clip = self.clip
        trail = pose.trail if clip.flies else clip.on_ground(pose.trail)
        seen = np.linalg.norm(trail - camera.target, axis=1) * camera.scale < reach
        since = int(np.flatnonzero(~seen)[-1]) + 1 if not seen.all() else 0
        since = min(since, len(trail) - 1)
        every = np.unique(np.linspace(since, len(trail) - 1, TRAIL + 1).astype(int))
        trail = trail[every]
        pieces = np.stack([trail[:-1], trail[1:]], axis=1)
        away = np.linalg.norm(pieces.mean(axis=1) - camera.target, axis=1) * camera.scale / reach
        self.trail.set_paths(_paths_by_shade(camera, pieces, 1 - away))

    def _show_feet(self, camera: Camera, pose: Pose) -> None:
        clip, touching = self.clip, pose.touching
        standing = clip.on_ground(pose.contacts[touching])
        support = clip.on_ground(np.pad(hull(standing[:, :2]), ((0, 0), (0, 1))))
        self.support.set_verts([camera.project(support)[0]])
        size = clip.mark
        self.stance.set_verts(camera.project(clip.on_ground(discs(standing, size)))[0])
        self.stance.set_facecolors(self._feet[touching])
        swings = ~touching & ~self._lost
        swinging, depth = camera.project(pose.contacts[swings])
        radius = 0.75 * size * camera.scale_at(depth)
        circle = np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)
        if clip.named:
            self._show_names(camera, pose)
        self.swing.set_segments(list(swinging[:, None] + radius[:, None, None] * circle))
        self.swing.set_colors(self._feet[swings])
        hips, depth = camera.project(pose.contacts[self._lost])
        arms = size * camera.scale_at(depth)[:, None, None, None] * _CROSS
        self.lost.set_segments([*(hips[:, None, None] + arms).reshape(-1, 2, 2)])


def _paths_by_shade(camera: Camera, pieces: Points, strength: Points) -> Sequence[Any]:
    """Return pieces of lines (pieces, 2, 3) as one path per shade."""
    from matplotlib.path import Path

    ends, shade = shaded(camera, pieces, strength)
    paths = []
    for wanted in range(1, SHADES + 1):
        points = ends[shade == wanted].reshape(-1, 2)
        codes = np.full(len(points), Path.LINETO, dtype=Path.code_type)
        codes[::2] = Path.MOVETO
        paths.append(Path(points, codes))
    return paths


FILLED = 0.56, 0.52  # shares of the picture's width and height that a single body may fill
FILLED_BY_ALL = 0.8, 0.6  # shares that several bodies may fill together
MIN_BODY_SIZE = 0.08  # minimum size of each of several bodies, as a share of the picture's height
MAX_LEAD = 0.3  # maximum distance of the leader from the middle, as a share of that height


class World:
    """Everything in a picture except its background.

    Args:
        figure: figure to draw in, at `DPI`.
        size: width and height, pixels.
        race: the bodies.
        theme: colours of the picture.
        view: name of a view in `VIEWS`.
        heading: first and second line of text.
    """

    def __init__(
        self,
        figure: "Figure",
        size: tuple[int, int],
        race: Race,
        theme: SceneTheme,
        view: str,
        heading: tuple[str, str],
    ) -> None:
        from matplotlib.transforms import IdentityTransform

        width, height = size
        self.race, self.clips = race, race.clips
        self._figure, self._identity = figure, IdentityTransform()
        self._unit = relative_size(width, height)
        self._reach = 0.75 * float(np.hypot(width, height))
        several = len(self.clips) > 1
        rows = ROW * small_letters(size) * len(self.clips) if several else 0.0
        self._centre = np.array([width / 2, (height - rows) / 2])
        self.angles = view_angles(view, several)
        box, (across, above) = race.box, FILLED_BY_ALL if several else FILLED
        self.scale, self.middle = fit_box(
            box, self.angles, across * width, above * height - rows / 2, view
        )
        self._extent = max(float(np.ptp(box, axis=0).max()), race.span) if several else race.span
        if several and self.scale * race.span < MIN_BODY_SIZE * height:
            self.scale = MIN_BODY_SIZE * height / race.span
            race.room = MAX_LEAD * height / self.scale
            self.middle = np.zeros(3)
            self._extent = height / self.scale
        self.grid = self._add(GridLines(theme, 0.8 * 1.3 * self._unit), 2)
        colours = [theme.body(number) for number in range(len(self.clips))]
        self.runners = [
            Runner(self._add, clip, theme, colour, self._unit, size)
            for clip, colour in zip(self.clips, colours, strict=True)
        ]
        step = fine_step(self.scale, self._unit)
        self.labels = Labels(figure, size, self.clips, theme, colours, step, heading)

    def _add(self, artist: Any, order: int) -> Any:
        artist.set_transform(self._identity)
        self._figure.add_artist(artist, clip=False)
        artist.set_zorder(order)
        return artist

    def show(self, seconds: float, turned: float = 0.0) -> None:
        """Move everything to its position at a moment.

        Args:
            seconds: time since the clips began.
            turned: angle of the camera around the bodies, degrees.
        """
        poses = [clip.at(seconds) for clip in self.clips]
        azimuth, elevation = self.angles
        camera = Camera(
            self.race.aim(poses) + self.middle,
            *axes(azimuth + turned, elevation),
            distance=DISTANCE * self._extent,
            scale=self.scale,
            centre=self._centre,
        )
        lead = self.clips[self.race.leader]
        ends, strength = grid(camera, self._extent, self._reach, self._unit, lead.corners)
        self.grid.show(camera, lead.on_ground(ends), strength)
        self._show_runners(camera, poses)
        self.labels.set_clock(poses, seconds)

    def _show_runners(self, camera: Camera, poses: Sequence[Pose]) -> None:
        """Show the bodies, with near ones in front of far ones."""
        depths = [float(camera.project(pose.middle)[1]) for pose in poses]
        order = np.argsort(np.argsort(depths)[::-1]) if len(poses) > 1 else [0]
        for runner, pose, place in zip(self.runners, poses, order, strict=True):
            runner.show(camera, pose, self._reach, int(place))
