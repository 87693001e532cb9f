"""Uneven ground: heights on a square lattice."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Heights = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Terrain:
    """Ground of triangles between corners on a square lattice; level with its edges beyond it.

    Attributes:
        heights: of the corners by y and x, ascending, (rows, columns) m.
        spacing: of the corners, m.
        corner: x and y of the first one, m.
    """

    heights: Heights
    spacing: float
    corner: tuple[float, float]

    @property
    def corners(self) -> tuple[Heights, Heights]:
        """The x and the y of the corners, (columns,) and (rows,) m."""
        rows, columns = (np.arange(count, dtype=np.float64) for count in self.heights.shape)
        x, y = self.corner
        return np.asarray(x + self.spacing * columns), np.asarray(y + self.spacing * rows)

    def height(self, points: NDArray[np.floating]) -> Heights:
        """Return the heights of the ground at x and y, (…, 2 or more) m -> (…,) m.

        The squares are cut from their first corner to the opposite one, as MuJoCo does.
        """
        last = np.array(self.heights.shape[::-1]) - 1
        place = np.clip((points[..., :2] - self.corner) / self.spacing, 0, last)
        square = np.minimum(place.astype(np.intp), last - 1)
        column, row = np.moveaxis(square, -1, 0)
        u, v = np.moveaxis(place - square, -1, 0)
        first, across = self.heights[row, column], self.heights[row + 1, column + 1]
        beside = np.where(v >= u, self.heights[row + 1, column], self.heights[row, column + 1])
        near, far = np.minimum(u, v), np.maximum(u, v)
        return np.asarray(first + far * (beside - first) + near * (across - beside))
