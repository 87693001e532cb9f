"""Outlines in the picture: limbs, plates, discs."""

import numpy as np

from gaitsim.gait.support import convex_hull
from gaitsim.render.scene.camera import Points

_ARC = np.linspace(-np.pi / 2, np.pi / 2, 12)  # a round end
_CIRCLE = np.linspace(0, 2 * np.pi, 25)[:-1]


def capsules(ends: Points, radii: Points) -> Points:
    """Outline tapered limbs with round ends (limbs, 2, 2) and radii (limbs, 2), in pixels.

    Returns:
        Their outlines, (limbs, corners, 2).
    """
    along = ends[:, 1] - ends[:, 0]
    angle = np.arctan2(along[:, 1], along[:, 0])
    turn = angle[:, None, None] + np.stack([_ARC + np.pi, _ARC])  # (limbs, 2, arc)
    arcs = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * radii[:, :, None, None]
    return (ends[:, :, None] + arcs).reshape(len(ends), 2 * len(_ARC), 2)


def discs(centres: Points, radius: float) -> Points:
    """Outline circles on the ground: centres (discs, 3) -> (discs, corners, 3), metres."""
    circle = np.zeros((len(_CIRCLE), 3))
    circle[:, 0], circle[:, 1] = np.cos(_CIRCLE), np.sin(_CIRCLE)
    return np.asarray(centres[:, None] + radius * circle)


def hull(points: Points) -> Points:
    """Return the corners of the convex hull of (points, 2), in order; none where it has no area."""
    corners = convex_hull(points)
    return corners if len(corners) > 2 else points[:0]
