"""Frames and the intervals between them.

A foot that touches the ground in a frame is assumed to touch it until the next frame; bodies make
the same assumption. Support, slip and other quantities of stance are therefore computed for the
interval from one frame to the next, with positions in the middle of the interval. The last frame
has the values of the interval before it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def half_way(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the positions, (frames, …), in the middle of the interval after each frame."""
    exact = places.astype(np.float64)
    if len(exact) > 1:
        exact[:-1] = (exact[:-1] + exact[1:]) / 2
        exact[-1] = exact[-2]
    return exact


def steps(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the horizontal distance moved, (frames − 1, …), by points, (frames, …, 3), m."""
    moved = np.diff(places[..., :2].astype(np.float64), axis=0)
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]))
