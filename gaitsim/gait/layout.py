"""The side of each foot and its place along the body, derived from the positions of the feet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.intervals import Floats

_MIDDLE = 0.02  # largest distance from the midline of a foot on neither side, as a share of width


@dataclass(frozen=True, eq=False)
class Layout:
    """Feet in pairs.

    Attributes:
        pairs: number of pairs.
        side: side of each foot, (feet,): 0 left, 1 right.
        place: place of each foot, (feet,): 0 is the foremost on its side.
    """

    pairs: int
    side: NDArray[np.intp]
    place: NDArray[np.intp]


def in_body_frame(points: Floats, path: Floats, turned: Floats | None) -> Floats:
    """Return points over time, (frames, points, 3), relative to the body's position and heading."""
    away = points - path[:, None]
    if turned is None:
        return away
    cos, sin = np.cos(turned)[:, None], np.sin(turned)[:, None]
    return np.stack(
        [
            cos * away[..., 0] + sin * away[..., 1],
            cos * away[..., 1] - sin * away[..., 0],
            away[..., 2],
        ],
        axis=-1,
    )


def layout_of(feet: Floats) -> Layout | None:
    """Return the pairs of feet; None if the numbers of left and right feet differ.

    Args:
        feet: positions relative to the body, (frames, feet, 3), metres: x forward, y left.
    """
    x, y, _ = feet.mean(axis=0).T
    width = np.abs(y).max(initial=0.0)
    left, right = np.flatnonzero(y > _MIDDLE * width), np.flatnonzero(y < -_MIDDLE * width)
    if not len(left) or len(left) != len(right) or len(left) + len(right) != len(x):
        return None
    side, place = np.zeros(len(x), dtype=np.intp), np.zeros(len(x), dtype=np.intp)
    for number, feet_of_side in enumerate((left, right)):
        side[feet_of_side] = number
        place[feet_of_side[np.argsort(-x[feet_of_side])]] = np.arange(len(left))
    return Layout(len(left), side, place)


def body_order(feet: Floats) -> NDArray[np.intp]:
    """Return the order of feet from left to right and front to back, (feet,): L1 L2 … R1 R2 …"""
    layout = layout_of(feet)
    if layout is None:
        return np.argsort(-feet.mean(axis=0)[:, 0], kind="stable")
    return np.lexsort((layout.place, layout.side))
