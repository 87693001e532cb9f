"""Cursor movement between the occupied cells of a panel."""

import numpy as np
from numpy.typing import NDArray

Place = tuple[int, int]
"""The column and the row of a panel's cell, from the low ends of its axes."""
Occupied = NDArray[np.bool_]


def next_occupied(occupied: Occupied, place: Place, across: int, up: int) -> Place:
    """Return the nearest occupied cell in a direction, or the same cell if there is none.

    Cells within 45 degrees of the direction are preferred.

    Args:
        occupied: whether each cell has an elite, (across, up).
        place: cell at which the cursor is.
        across: horizontal direction, −1, 0 or 1.
        up: vertical direction, −1, 0 or 1; 0 unless `across` is 0.
    """
    cells = np.argwhere(occupied)
    away = cells - np.array(place)
    ahead, aside = away @ (across, up), np.abs(away @ (up, across))
    for within in (aside <= ahead, ahead > 0):
        chosen = np.flatnonzero((ahead > 0) & within)
        if len(chosen):
            # A cell straight ahead is preferred to a nearer cell beside the line.
            best = chosen[np.argmin(ahead[chosen] + 2 * aside[chosen])]
            return int(cells[best, 0]), int(cells[best, 1])
    return place


def nearest(occupied: Occupied, place: Place) -> Place | None:
    """Return the occupied cell nearest to a cell; None if all cells are empty."""
    cells = np.argwhere(occupied)
    if not len(cells):
        return None
    best = np.argmin(((cells - np.array(place)) ** 2).sum(1))
    return int(cells[best, 0]), int(cells[best, 1])
