"""A pinhole camera and its viewpoints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# Azimuth and elevation of the camera as seen from the body, degrees. At −90° the camera is on the
# body's right, so forward points to the right of the picture.
VIEWS = {"iso": (-58.0, 27.0), "side": (-90.0, 7.0), "top": (-90.0, 90.0), "orbit": (-58.0, 27.0)}
MIN_ELEVATION = 24.0  # minimum elevation of the camera for several bodies, degrees
DISTANCE = 7.0  # distance from the target, in reaches of the body: near enough to show depth
NEAR = 0.15  # share of that distance within which nothing is drawn


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera that looks at a target.

    Attributes:
        target: point at the centre of the picture, (3,) m.
        right, up, ahead: axes of the camera, unit vectors (3,).
        distance: distance from the target, m.
        scale: scale of the picture at the target, pixels per metre.
        centre: centre of the picture, (2,) pixels from the lower left corner.
    """

    target: Points
    right: Points
    up: Points
    ahead: Points
    distance: float
    scale: float
    centre: Points

    def project(self, points: Points) -> tuple[Points, Points]:
        """Project points (…, 3) to pixels (…, 2) and depths (…), m; near depths are clamped."""
        axes = np.array([self.right, self.up, self.ahead]).T
        seen = ((points - self.target).reshape(-1, 3) @ axes).reshape(points.shape)
        depth = np.maximum(seen[..., 2] + self.distance, NEAR * self.distance)
        scale = self.scale * self.distance / depth
        return self.centre + seen[..., :2] * scale[..., None], depth

    def scale_at(self, depth: Points) -> Points:
        """Return the pixels per metre at a depth."""
        return self.scale * self.distance / depth

    def in_front(self, depth: Points) -> NDArray[np.bool_]:
        """Return whether each depth is far enough to be drawn, and hence not clamped."""
        return depth > NEAR * self.distance * 1.001


def view_angles(view: str, several: bool) -> tuple[float, float]:
    """Return the azimuth and elevation of a view of one or several bodies, degrees."""
    azimuth, elevation = VIEWS[view]
    return azimuth, max(elevation, MIN_ELEVATION) if several else elevation


def axes(azimuth: float, elevation: float) -> tuple[Points, Points, Points]:
    """Return the right, up and ahead axes of a camera at these angles from its target, degrees."""
    a, e = np.radians([azimuth, elevation])
    ahead = -np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(right, ahead), ahead


def fit_box(
    box: Points, angles: tuple[float, float], width: float, height: float, view: str
) -> tuple[float, Points]:
    """Return the scale at which a body fills its part of a picture, and the body's middle.

    Args:
        box: points of the body relative to its path, (points, 3) m.
        angles: azimuth and elevation of the camera, degrees.
        width: width of the part of the picture to fill, pixels.
        height: height of that part, pixels.
        view: name of a view in `VIEWS`.

    Returns:
        Pixels per metre, and the middle of the visible body relative to its path, (3,) m.
    """
    right, up, _ = axes(*angles)
    if view == "orbit":
        wide, tall, middle = extent_from_all_sides(box, up)
        tall += 0.2 * wide
    else:
        across, above = box @ right, box @ up
        wide, tall = float(np.ptp(across)), float(np.ptp(above))
        middle = right * (across.min() + across.max()) / 2 + up * (above.min() + above.max()) / 2
    scale = min(width / max(wide, 1e-9), height / max(tall, 1e-9))
    return scale, middle


def extent_from_all_sides(box: Points, up: Points) -> tuple[float, float, Points]:
    """Return the greatest width of a body from any side, its height along `up`, and its middle."""
    wide = 2 * float(np.hypot(box[:, 0], box[:, 1]).max())
    middle = np.array([0.0, 0.0, (box[:, 2].min() + box[:, 2].max()) / 2])
    return wide, float(np.ptp(box @ up)), middle


def smooth_path(path: Points, frame_rate: float, seconds: float = 0.2) -> Points:
    """Smooth a path (frames, 3) with a Gaussian in time, for the camera to follow."""
    sigma = seconds * frame_rate
    half = min(int(3 * sigma), len(path) - 1)
    if half < 1:
        return path
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    weights /= weights.sum()
    # The ends are mirrored, so that a steady walk remains steady.
    padded = np.pad(path, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    return np.stack([np.convolve(axis, weights, mode="valid") for axis in padded.T], axis=1)
