"""A body on the ground at one moment, in braille dots."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.colours import is_damaged, sides
from gaitsim.render.scene.camera import DISTANCE, VIEWS, Camera, Points, axes, extent_from_all_sides
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.terminal.braille import (
    HIGH,
    WIDE,
    Dots,
    Inks,
    Paper,
    cells,
    draw_lines,
    draw_points,
    empty,
)
from gaitsim.render.terminal.scales import annotate, headings
from gaitsim.render.ticks import round_step

FILLED = 0.88, 0.80  # shares of a picture's width and height that a body fills
MAX_ZOOM, MIN_ZOOM = 16.0, 1 / 16
MIN_EXTENT = 1e-6  # metres: least size assumed for a body, which may be a point

NAMED = {**{name: VIEWS[name] for name in ("iso", "side", "top")}, "front": (0.0, 12.0)}


@dataclass(frozen=True)
class Viewpoint:
    """A camera's direction and zoom.

    Attributes:
        azimuth: direction of the camera as seen from the body, degrees; −90 is the body's right.
        elevation: elevation of the camera, 0 to 90 degrees.
        zoom: magnification; 1 shows the whole body, or without `follow` its whole path.
        follow: whether the camera follows the body.
    """

    azimuth: float = VIEWS["iso"][0]
    elevation: float = VIEWS["iso"][1]
    zoom: float = 1.0
    follow: bool = True

    @property
    def name(self) -> str:
        """The name of this direction in `NAMED`, or ''."""
        here = (self.azimuth, self.elevation)
        return next((name for name, angles in NAMED.items() if angles == here), "")

    def turned(self, azimuth: float, elevation: float) -> "Viewpoint":
        """Return the view turned by angles in degrees, never below the ground."""
        return replace(
            self,
            azimuth=(self.azimuth + azimuth + 180) % 360 - 180,
            elevation=min(max(self.elevation + elevation, 0.0), 90.0),
        )

    def zoomed(self, factor: float) -> "Viewpoint":
        """Return the view magnified by a factor, within limits."""
        return replace(self, zoom=min(max(self.zoom * factor, MIN_ZOOM), MAX_ZOOM))

    def following(self, follow: bool) -> "Viewpoint":
        """Return the view with a camera that follows the body or shows its whole path."""
        return replace(self, follow=follow, zoom=1.0)

    def named(self, name: str) -> "Viewpoint":
        """Return the view from a direction in `NAMED`."""
        azimuth, elevation = NAMED[name]
        return replace(self, azimuth=azimuth, elevation=elevation)

    def next(self) -> "Viewpoint":
        """Return the view from the next direction in `NAMED`, or the first from an unnamed one."""
        names = list(NAMED)
        return self.named(names[(names.index(self.name) + 1) % len(names) if self.name else 0])


def camera(view: Viewpoint, clip: Clip, pose: Pose, width: int, height: int) -> Camera:
    """Return the camera of a picture of `width` × `height` dots, with y up from its lower edge."""
    right, up, ahead = axes(view.azimuth, view.elevation)
    if view.follow:
        # Equally wide from all sides: the size stays constant while the camera turns.
        wide, tall, middle = extent_from_all_sides(clip.box, up)
        target, reach = pose.aim + middle, wide / 2
    else:
        box = _motion_box(clip)
        across, above = box @ right, box @ up
        wide, tall = float(np.ptp(across)), float(np.ptp(above))
        target = (box.min(axis=0) + box.max(axis=0)) / 2
        reach = float(np.linalg.norm(np.ptp(box, axis=0))) / 2
    scale = min(
        FILLED[0] * width / max(wide, MIN_EXTENT), FILLED[1] * height / max(tall, MIN_EXTENT)
    )
    return Camera(
        np.asarray(target, dtype=np.float64),
        *(right, up, ahead),
        distance=DISTANCE * max(reach, MIN_EXTENT),
        scale=scale * view.zoom,
        centre=np.array([(width - 1) / 2, (height - 1) / 2]),
    )


def _motion_box(clip: Clip) -> Points:
    """Return the corners of a box around a body's whole motion, (8, 3) m."""
    low = clip.path.min(axis=0) + clip.box.min(axis=0)
    high = clip.path.max(axis=0) + clip.box.max(axis=0)
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


# Inks; a higher one covers a lower one.
GROUND, TRACK = 1, 2
BODY = 3  # + SIDES × shade + side, so that near segments cover far ones
SIDES, SHADES = 3, 3  # the last shade is the nearest
DAMAGED = BODY + SIDES * SHADES
FOOT = DAMAGED + 1  # + side
LABEL = FOOT + SIDES

STANCE, LOST = ord("●"), ord("×")
LINE_DISTANCE, MAX_LINES = (
    12.0,
    12,
)  # approximate dots between two lines of the ground, and lines across it
DOTS_PER_SQUARE = 4  # dots of a line of the ground between two crossings
REACH = 0.75  # extent of the ground around the body, in widths of the picture
MIN_LINE_DISTANCE = 1.5  # least distance in dots between lines of the ground that are drawn
BOLD_HEIGHT = 150  # height of a picture, in dots, from which lines are two dots wide
MAX_TRAIL_POINTS = 80  # maximum number of points drawn of a path


def picture(
    clip: Clip, seconds: float, view: Viewpoint, columns: int, rows: int, *, ground: bool = True
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw a body at a moment, as code points and their inks, both (rows, columns).

    Args:
        clip: the body in motion.
        seconds: time since the motion began.
        view: direction and zoom of the camera.
        columns: width of the picture.
        rows: height of the picture.
        ground: whether to draw the ground. It causes most of the changes between pictures when
            the camera follows the body.
    """
    if columns <= 0 or rows <= 0:
        return cells(empty(columns, rows))
    pose = clip.at(seconds)
    eye = camera(view, clip, pose, columns * WIDE, rows * HIGH)
    turned = headings(clip.skeleton)
    frame = int(seconds * clip.skeleton.frame_rate + 1e-6)
    yaw = None if turned is None else float(turned[min(frame, len(turned) - 1)])
    return draw_body(eye, clip, pose, yaw, columns, rows, ground=ground)


def draw_body(
    eye: Camera,
    clip: Clip,
    pose: Pose,
    yaw: float | None,
    columns: int,
    rows: int,
    *,
    ground: bool = True,
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw a body in a pose as seen by a camera, as code points and inks, both (rows, columns).

    Args:
        eye: the camera, in dots.
        clip: the body.
        pose: the body's pose.
        yaw: turn to the left since the start, radians; None for a body without a heading.
        columns: width of the picture.
        rows: height of the picture.
        ground: whether to draw the ground.
    """
    dots = empty(columns, rows)
    height = len(dots)
    if ground:
        _ground(dots, eye, clip)
    drawn = clip.skeleton
    hurt = is_damaged(drawn.names, drawn.damaged)
    limbs, shades = _limbs(eye, pose.segments, sides(drawn.names), hurt, height)
    track = _track(eye, clip, pose, height)
    draw_lines(dots, np.concatenate([track, limbs]), np.append(np.full(len(track), TRACK), shades))
    if clip.named:
        draw_lines(dots, _project(eye, _front(clip, pose), height)[0], np.full(3, LABEL))
    codes, inks = cells(dots, behind=TRACK)
    names = drawn.contact_names or ("",) * len(pose.contacts)
    if len(pose.contacts):
        lost = is_damaged(names, drawn.damaged)
        at = np.rint((_project(eye, pose.contacts, height)[0] - (0.5, 1.5)) / (2, 4)).astype(
            np.intp
        )
        inside = ((at >= 0) & (at < (columns, rows))).all(axis=1)
        for shown, sign, ink in (
            (pose.touching & ~lost, STANCE, FOOT + sides(names)),
            (lost, LOST, np.full(len(names), DAMAGED)),
        ):
            x, y = at[shown & inside].T
            codes[y, x] = sign
            inks[y, x] = ink[shown & inside]
    if clip.named:
        marks = [("○", pin) for pin in (() if clip.pins is None else clip.pins)]
        marks += [("front", _front(clip, pose)[0, 1]), *zip(names, pose.contacts, strict=True)]
        flat = _project(eye, np.array([place for _, place in marks]), height)[0]
        for (text, _), (x, y) in zip(marks, np.rint(flat / (WIDE, HIGH)).astype(int), strict=True):
            if 0 <= x < columns and 0 <= y < rows:
                Paper(codes, inks).write(y, x + (text != "○"), text, LABEL)
    annotate(codes, inks, LABEL, eye, clip, pose, yaw)
    return codes, inks


def _front(clip: Clip, pose: Pose) -> Points:
    """Return an arrow on the ground ahead of a body, three lines to its tip, (3, 2, 3) m."""
    nose, span = pose.segments[..., 0].max(), clip.anatomy.span
    tip = np.array([nose + 0.45 * span, pose.middle[1], 0.0])
    ends = tip - span * np.array([[0.35, 0, 0], [0.12, 0.08, 0], [0.12, -0.08, 0]])
    return clip.on_ground(np.stack([ends, np.broadcast_to(tip, ends.shape)], axis=1))


def _project(eye: Camera, points: Points, height: int) -> tuple[Points, Points]:
    """Return dots (…, 2) from the upper left corner, and depths (…)."""
    flat, depth = eye.project(points)
    flat[..., 1] = height - 1 - flat[..., 1]
    return flat, depth


def _ground(dots: Dots, eye: Camera, clip: Clip) -> None:
    """Draw lines of dots at fixed places in the world, which make the body's movement visible."""
    height, width = dots.shape
    foot = np.array([eye.target[0], eye.target[1], 0.0])
    scale = float(eye.scale_at(eye.project(foot)[1]))
    step = round_step(max(LINE_DISTANCE, width / MAX_LINES) / scale)
    reach = min(REACH * width / scale, 0.8 * eye.distance)
    lines = int(reach / step)
    across = np.arange(-lines, lines + 1) * step
    along = np.arange(-lines * DOTS_PER_SQUARE, lines * DOTS_PER_SQUARE + 1) * (
        step / DOTS_PER_SQUARE
    )
    grid = np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)
    points = np.zeros((2 * len(grid), 3))
    points[:, :2] = np.concatenate([grid, grid[:, ::-1]]) + np.rint(foot[:2] / step) * step
    points = points[np.linalg.norm(points[:, :2] - foot[:2], axis=1) <= reach]
    flat, depth = _project(eye, clip.on_ground(points), height)
    # From a low camera, lines behind one another would merge into a solid floor.
    apart = eye.scale_at(depth) * step * max(-float(eye.ahead[2]), 0.1)
    draw_points(dots, flat[eye.in_front(depth) & (apart >= MIN_LINE_DISTANCE)], GROUND)


def _track(eye: Camera, clip: Clip, pose: Pose, height: int) -> Points:
    """Return the body's past path (lines, 2, 2), on the ground or, if it flies, in the air."""
    every = max(1, len(pose.trail) // MAX_TRAIL_POINTS)
    trail = pose.trail[::-every][::-1]
    if not clip.flies:
        trail = clip.on_ground(trail)
    flat, depth = _project(eye, trail, height)
    seen = eye.in_front(depth)
    return np.stack([flat[:-1], flat[1:]], axis=1)[seen[:-1] & seen[1:]]


def _limbs(
    eye: Camera, segments: Points, side: NDArray[np.intp], damaged: NDArray[np.bool_], height: int
) -> tuple[Points, NDArray[np.intp]]:
    """Return lines (lines, 2, 2) and their inks, by side and distance, or for damage."""
    ends, depth = _project(eye, segments, height)
    middle = depth.mean(axis=1)
    spread = float(np.ptp(middle))
    share = (middle.max() - middle) / spread if spread > 1e-3 * eye.distance else np.ones(len(side))
    shade = np.minimum((share * SHADES).astype(np.intp), SHADES - 1)
    inks = np.where(damaged, DAMAGED, BODY + SIDES * shade + side)
    if height < BOLD_HEIGHT:
        return ends, inks
    steep = np.abs(ends[:, 1] - ends[:, 0]).argmax(axis=1) == 1
    beside = np.where(steep[:, None], (1.0, 0.0), (0.0, 1.0))[:, None]
    return np.concatenate([ends, ends + beside]), np.tile(inks, 2)
