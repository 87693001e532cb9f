"""From where a body is looked at, and how large it is drawn."""

from dataclasses import dataclass, replace

import numpy as np

from gaitsim.render.scene.camera import DISTANCE, VIEWS, Camera, Points, all_round, axes
from gaitsim.render.scene.clip import Clip, Pose

FILLED = 0.88, 0.80  # shares of a picture's width and height that a body fills
CLOSEST, FARTHEST = 16.0, 1 / 16
SMALLEST = 1e-6  # metres: a body that is a point is drawn as if it were so large

NAMED = {**{name: VIEWS[name] for name in ("iso", "side", "top")}, "front": (0.0, 12.0)}


@dataclass(frozen=True)
class Viewpoint:
    """A camera's direction and zoom.

    Attributes:
        azimuth: of the camera as seen from the body, degrees; at −90 it stands on its right.
        elevation: of the camera, degrees, 0 to 90.
        zoom: 1 shows the whole body, or without `follow` its whole way.
        follow: whether the camera goes with the body.
    """

    azimuth: float = VIEWS["iso"][0]
    elevation: float = VIEWS["iso"][1]
    zoom: float = 1.0
    follow: bool = True

    @property
    def name(self) -> str:
        """Of the named view that it is, or ''."""
        here = (self.azimuth, self.elevation)
        return next((name for name, angles in NAMED.items() if angles == here), "")

    def turned(self, azimuth: float, elevation: float) -> "Viewpoint":
        """Turned by so many degrees; it never goes below the ground."""
        return replace(
            self,
            azimuth=(self.azimuth + azimuth + 180) % 360 - 180,
            elevation=min(max(self.elevation + elevation, 0.0), 90.0),
        )

    def zoomed(self, factor: float) -> "Viewpoint":
        """Nearer by a factor, within limits."""
        return replace(self, zoom=min(max(self.zoom * factor, FARTHEST), CLOSEST))

    def following(self, follow: bool) -> "Viewpoint":
        """With a camera that goes with the body, or shows its whole way."""
        return replace(self, follow=follow, zoom=1.0)

    def named(self, name: str) -> "Viewpoint":
        """In the direction of one of `NAMED`."""
        azimuth, elevation = NAMED[name]
        return replace(self, azimuth=azimuth, elevation=elevation)

    def next(self) -> "Viewpoint":
        """In the direction of the next of `NAMED`; of the first where it is in none."""
        names = list(NAMED)
        return self.named(names[(names.index(self.name) + 1) % len(names) if self.name else 0])


def camera(view: Viewpoint, clip: Clip, pose: Pose, width: int, height: int) -> Camera:
    """The camera of a picture of so many dots, y upwards from its lower edge."""
    right, up, ahead = axes(view.azimuth, view.elevation)
    if view.follow:
        # As wide from every side, so that a body does not grow and shrink as it is turned.
        wide, tall, middle = all_round(clip.box, up)
        target, reach = pose.aim + middle, wide / 2
    else:
        box = _way(clip)
        across, above = box @ right, box @ up
        wide, tall = float(np.ptp(across)), float(np.ptp(above))
        target = (box.min(axis=0) + box.max(axis=0)) / 2
        reach = float(np.linalg.norm(np.ptp(box, axis=0))) / 2
    scale = min(FILLED[0] * width / max(wide, SMALLEST), FILLED[1] * height / max(tall, SMALLEST))
    return Camera(
        np.asarray(target, dtype=np.float64),
        *(right, up, ahead),
        distance=DISTANCE * max(reach, SMALLEST),
        scale=scale * view.zoom,
        centre=np.array([(width - 1) / 2, (height - 1) / 2]),
    )


def _way(clip: Clip) -> Points:
    """Corners of a box around all the places where a body comes to, (8, 3) m."""
    low = clip.path.min(axis=0) + clip.box.min(axis=0)
    high = clip.path.max(axis=0) + clip.box.max(axis=0)
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
