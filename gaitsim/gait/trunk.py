"""The trunk, which is the rigid part of a body, and its heading."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.gait.intervals import Floats

_FRAMES = 30  # number of frames in which distances are compared
_SEGMENTS = 200  # number of segments compared, for bodies with thousands of them
_RIGID = 1e-4  # tolerance for distances within the trunk, as a share of the body's size

_SEEN = 0.3  # least share of the shape that is visible from above in a body with a heading


def size(skeleton: Skeleton) -> float:
    """Return the longest diagonal of the box around the body over time, metres."""
    points = skeleton.segments.reshape(len(skeleton.segments), -1, 3).astype(np.float64)
    return float(np.linalg.norm(np.ptp(points, axis=1), axis=-1).max(initial=0.0))


@lru_cache(4)  # it takes 3 ms, and several measures of a motion and its picture need it
def trunk(skeleton: Skeleton) -> Floats:
    """Return the points of the trunk over time, (frames, points, 3), metres.

    For each segment, the ends of all segments that keep a constant distance from both of its ends
    form a rigid group. The trunk is the group with the most distinct points; ties go to the group
    of the first segment.
    """
    every = -(-skeleton.segments.shape[1] // _SEGMENTS)
    segments = skeleton.segments[:, ::every].astype(np.float64)
    points = segments.reshape(len(segments), -1, 3)
    compared = np.unique(np.linspace(0, len(points) - 1, _FRAMES).astype(int))
    least = np.full((points.shape[1],) * 2, np.inf)
    most = np.zeros_like(least)
    for frame in compared:
        distance = np.linalg.norm(points[frame, :, None] - points[frame], axis=-1)
        least, most = np.minimum(least, distance), np.maximum(most, distance)
    rigid = most - least <= _RIGID * size(skeleton)
    places = np.unique(points[0].round(9), axis=0, return_inverse=True)[1].ravel()
    groups = [rigid[2 * segment] & rigid[2 * segment + 1] for segment in range(segments.shape[1])]
    best: NDArray[np.bool_] = max(groups, key=lambda group: len(np.unique(places[group])))
    if not best.any():  # no segment has a constant length
        best[:2] = True
    found: Floats = points[:, best]
    found.flags.writeable = False
    return found


def heading(body: Floats) -> Floats | None:
    """Return the turn of a rigid group of points to the left since the start, seen from above.

    Args:
        body: positions of the points, (frames, points, 3), metres.

    Returns:
        The turn, (frames,), radians, not wrapped; None if the points lie almost vertically above
        one another in any frame, as a body that tumbles has no heading.
    """
    flat = body[..., :2] - body[..., :2].mean(axis=1, keepdims=True)
    if np.abs(flat).max(initial=0.0) < 1e-9:
        return None
    x, y = flat[0].T
    along = flat[..., 0] @ x + flat[..., 1] @ y
    across = flat[..., 1] @ x - flat[..., 0] @ y
    if np.hypot(along, across).min() < _SEEN * along[0]:
        return None
    return np.asarray(np.unwrap(np.arctan2(across, along)))
