"""The direction and the size in which a body is drawn."""

from dataclasses import dataclass, replace

import numpy as np

from gaitsim.render.scene.camera import DISTANCE, VIEWS, Camera, Points, axes, extent_from_all_sides
from gaitsim.render.scene.clip import Clip, Pose

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
