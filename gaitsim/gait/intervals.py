"""Frames and the intervals between them.

A foot that touches the ground in a frame is assumed to do so until the next frame, as in the
bodies themselves. Support, slip and other quantities of stance are therefore computed for the
interval from one frame to the next, with positions in the middle of the interval. The last frame
repeats the interval before it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def half_way(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the positions in the middle of each interval, (frames, …) -> (frames, …)."""
    exact = places.astype(np.float64)
    if len(exact) > 1:
        exact[:-1] = (exact[:-1] + exact[1:]) / 2
        exact[-1] = exact[-2]
    return exact


def steps(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the horizontal distance in each interval, (frames, …, 3) -> (frames − 1, …), m."""
    moved = np.diff(places[..., :2].astype(np.float64), axis=0)
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]))
