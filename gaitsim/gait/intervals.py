"""Frames and the intervals between them.

A foot that touches in a frame is taken to touch until the next frame, as the bodies have
it. So whatever concerns stance, such as support and slip, is judged on the interval from
a frame to the next: where a thing is, is its place half-way; the last frame repeats the
interval before it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def half_way(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the places in the middle of each interval, (frames, …) -> (frames, …)."""
    exact = places.astype(np.float64)
    if len(exact) > 1:
        exact[:-1] = (exact[:-1] + exact[1:]) / 2
        exact[-1] = exact[-2]
    return exact


def steps(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the horizontal distance of each interval, (frames, …, 3) -> (frames − 1, …), m."""
    moved = np.diff(places[..., :2].astype(np.float64), axis=0)
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]))
