"""Voronoi cells in a rectangle, as polygons."""

import numpy as np
from numpy.typing import NDArray


def polygons(centres: NDArray[np.float64], ends: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the cell of each centre, clipped to a rectangle.

    Distances are relative to the sides of the rectangle. Mirroring the centres at the four sides
    makes the sides borders of cells.

    Args:
        centres: centres of the cells, inside the rectangle, (cells, 2).
        ends: low and high end of both axes, (2, 2).

    Returns:
        The corners of each cell in order, (corners, 2) each.
    """
    from scipy.spatial import Voronoi

    low, width = ends[:, 0], ends[:, 1] - ends[:, 0]
    shares = (centres - low) / width
    x, y = shares.T
    mirrored = [(-x, y), (2 - x, y), (x, -y), (x, 2 - y)]
    points = np.concatenate([shares, *(np.stack(image, 1) for image in mirrored)])
    found = Voronoi(points)
    corners = low + np.clip(found.vertices, 0, 1) * width
    return [corners[found.regions[region]] for region in found.point_region[: len(centres)]]
