"""Static stability: the distance from the centre to the edge of the support polygon."""

import numpy as np

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.gait.intervals import Floats, half_way

_LINE = 1e-6  # tolerance for points in a vertical plane, m


def stability_margin(skeleton: Skeleton) -> Floats:
    """Return the static stability margin over time, (frames,) float64, metres.

    The margin is the distance of the centre, seen from above, from the nearest edge of the support
    polygon, which is the convex hull of the feet on the ground (McGhee & Frank 1968, Mathematical
    Biosciences 3:331). It is negative if the centre is outside the polygon, and with one or two
    feet on the ground, which span no polygon. Without a foot on the ground, it is −inf. It is
    computed half-way from each frame to the next.

    A body whose centre and feet all move in one vertical plane along x, such as a planar walker,
    cannot tip sideways: its support extends from its hindmost to its foremost foot.
    """
    if skeleton.contacts is None or skeleton.touching is None:
        raise GaitsimError(
            "a body without feet has no stability margin",
            allowed="a skeleton with contacts and touching",
        )
    feet = half_way(skeleton.contacts)[..., :2]
    centre = half_way(skeleton.path)[:, :2]
    sideways = np.concatenate([feet[..., 1].ravel(), centre[:, 1]])
    planar = np.ptp(sideways) < _LINE
    margin = np.full(len(feet), -np.inf)
    for frame, (places, down) in enumerate(zip(feet, skeleton.touching, strict=True)):
        standing = places[down]
        if not len(standing):
            continue
        if planar:
            x = centre[frame, 0]
            margin[frame] = min(x - standing[:, 0].min(), standing[:, 0].max() - x)
        else:
            margin[frame] = distance_inside(convex_hull(standing), centre[frame])
    return margin


def distance_inside(corners: Floats, point: Floats) -> float:
    """Return the distance of a point to the edge of a convex polygon, negative outside.

    Args:
        corners: corners of the polygon, (corners, 2), counter-clockwise; two corners are a line and
            one is a point, which have no inside.
        point: position of the point, (2,).
    """
    along = np.roll(corners, -1, axis=0) - corners
    away = point - corners
    squares = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip((away * along).sum(axis=1) / squares, 0, 1)
    nearest = float(np.hypot(*(away - share[:, None] * along).T).min())
    left = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    return nearest if len(corners) > 2 and (left >= 0).all() else 0.0 - nearest


def convex_hull(points: Floats) -> Floats:
    """Return the corners of the convex hull, counter-clockwise, (corners, 2) (Andrew 1979)."""
    ordered = np.unique(points, axis=0).tolist()
    if len(ordered) < 3:
        return np.array(ordered)
    halves = []
    for sweep in (ordered, ordered[::-1]):
        half: list[list[float]] = []
        for point in sweep:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0:
                half.pop()
            half.append(point)
        halves += half[:-1]
    return np.array(halves)


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    """Return twice the area of a triangle, positive if a, b, c turn left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
