"""A pinhole camera and its viewpoints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# Azimuth and elevation of the camera as seen from the body, degrees: at −90° it stands on the
# body's right, so that forward is to the right of the picture.
VIEWS = {"iso": (-58.0, 27.0), "side": (-90.0, 7.0), "top": (-90.0, 90.0), "orbit": (-58.0, 27.0)}
DISTANCE = 7.0  # from the target, in reaches of the body: near enough to show depth
NEAR = 0.15  # of that distance: what is nearer is not drawn


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera that looks at a target.

    Attributes:
        target: what it looks at, (3,) m; shown at `centre`.
        right, up, ahead: its axes, unit vectors (3,).
        distance: from the target, m.
        scale: of the picture at the target, pixels a metre.
        centre: of the picture, (2,) pixels from the lower left corner.
    """

    target: Points
    right: Points
    up: Points
    ahead: Points
    distance: float
    scale: float
    centre: Points

    def project(self, points: Points) -> tuple[Points, Points]:
        """Project points (…, 3) to pixels (…, 2) and depths (…), m; clamp those that are near."""
        seen = points - self.target
        depth = np.maximum(seen @ self.ahead + self.distance, NEAR * self.distance)
        flat = np.stack([seen @ self.right, seen @ self.up], axis=-1)
        return self.centre + flat * (self.scale * self.distance / depth)[..., None], depth

    def scale_at(self, depth: Points) -> Points:
        """Return the pixels per metre at a depth."""
        return self.scale * self.distance / depth

    def in_front(self, depth: Points) -> NDArray[np.bool_]:
        """Return which depths are not clamped."""
        return depth > NEAR * self.distance * 1.001


def axes(azimuth: float, elevation: float) -> tuple[Points, Points, Points]:
    """Return right, up and ahead of a camera at these angles from its target, degrees."""
    a, e = np.radians([azimuth, elevation])
    ahead = -np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(right, ahead), ahead


def fitting(
    box: Points, angles: tuple[float, float], width: float, height: float, view: str
) -> tuple[float, Points]:
    """Return the scale at which a body fills its share of a picture, and its middle.

    Args:
        box: the body's points about its path, (points, 3) m.
        angles: azimuth and elevation of the camera, degrees.
        width: of the part of the picture that it may fill, pixels.
        height: of that part.
        view: one of `VIEWS`.

    Returns:
        Pixels a metre, and the middle of what is seen about the path, (3,) m.
    """
    right, up, _ = axes(*angles)
    if view == "orbit":
        wide, tall, middle = all_round(box, up)
        tall += 0.2 * wide
    else:
        across, above = box @ right, box @ up
        wide, tall = float(np.ptp(across)), float(np.ptp(above))
        middle = right * (across.min() + across.max()) / 2 + up * (above.min() + above.max()) / 2
    scale = min(width / max(wide, 1e-9), height / max(tall, 1e-9))
    return scale, middle


def all_round(box: Points, up: Points) -> tuple[float, float, Points]:
    """Return the greatest width of a body from any side, its height along `up`, and its middle."""
    wide = 2 * float(np.hypot(box[:, 0], box[:, 1]).max())
    middle = np.array([0.0, 0.0, (box[:, 2].min() + box[:, 2].max()) / 2])
    return wide, float(np.ptp(box @ up)), middle


def steadied(path: Points, frame_rate: float, seconds: float = 0.2) -> Points:
    """Smooth a path (frames, 3) by a Gaussian in time, for the camera to follow."""
    sigma = seconds * frame_rate
    half = min(int(3 * sigma), len(path) - 1)
    if half < 1:
        return path
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    weights /= weights.sum()
    # Mirrored at its ends so that a steady walk stays one.
    padded = np.pad(path, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    return np.stack([np.convolve(axis, weights, mode="valid") for axis in padded.T], axis=1)
