"""Outlines of limbs, plates and discs."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.travel import convex_hull
from gaitsim.render.scene.camera import Points

_ARC = np.linspace(-np.pi / 2, np.pi / 2, 12)  # a round end
_CIRCLE = np.linspace(0, 2 * np.pi, 25)[:-1]


def capsules(ends: Points, radii: Points) -> Points:
    """Outline tapered limbs with round ends.

    Args:
        ends: (limbs, 2, 2) pixels.
        radii: (limbs, 2) pixels.

    Returns:
        The outlines, (limbs, corners, 2) pixels.
    """
    along = ends[:, 1] - ends[:, 0]
    angle = np.arctan2(along[:, 1], along[:, 0])
    turn = angle[:, None, None] + np.stack([_ARC + np.pi, _ARC])  # (limbs, 2, arc)
    arcs = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * radii[:, :, None, None]
    return (ends[:, :, None] + arcs).reshape(len(ends), 2 * len(_ARC), 2)


def discs(centres: Points, radius: float) -> Points:
    """Outline circles on the ground around centres (discs, 3); return (discs, corners, 3), m."""
    circle = np.zeros((len(_CIRCLE), 3))
    circle[:, 0], circle[:, 1] = np.cos(_CIRCLE), np.sin(_CIRCLE)
    return np.asarray(centres[:, None] + radius * circle)


def hull(points: Points) -> Points:
    """Return the corners of the convex hull of (points, 2) in order; none if it has no area."""
    corners = convex_hull(points)
    return corners if len(corners) > 2 else points[:0]


def outline(points: Points) -> Points:
    """Return an approximate convex hull of (points, 2): the farthest points in 24 directions.

    For the 160 points of a capsule it takes a tenth of the time of `hull`.
    """
    directions = np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])
    return np.asarray(points[(points @ directions).argmax(axis=0)])


def hull_faces(points: Points) -> list[NDArray[np.intp]]:
    """Return the faces of the convex hull of (points, 3); none if it has no volume.

    Returns:
        The indices of each face's corners, counter-clockwise from outside.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        return []
    faces = []
    for plane in np.unique(np.round(hull.equations, 6), axis=0):
        triangles = hull.simplices[(np.abs(hull.equations - plane) < 1e-5).all(axis=1)]
        corners = np.unique(triangles)
        away = points[corners] - points[corners].mean(axis=0)
        across = np.cross(plane[:3], away[0])
        order = np.argsort(np.arctan2(away @ across, away @ away[0]))
        faces.append(corners[order])
    return faces
