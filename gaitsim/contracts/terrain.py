"""Uneven ground: heights on a square lattice."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Heights = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Terrain:
    """Ground made of triangles between the corners of a square lattice.

    Outside the lattice, the height is the height of the nearest point on its edge.

    Attributes:
        heights: height of each corner, (rows, columns), m; y increases with the row, x with the
            column.
        spacing: distance between neighbouring corners, m.
        corner: x and y of the first corner, m.
    """

    heights: Heights
    spacing: float
    corner: tuple[float, float]

    @property
    def corners(self) -> tuple[Heights, Heights]:
        """The x coordinates, (columns,), and y coordinates, (rows,), of the corners, m."""
        rows, columns = (np.arange(count, dtype=np.float64) for count in self.heights.shape)
        x, y = self.corner
        return np.asarray(x + self.spacing * columns), np.asarray(y + self.spacing * rows)

    def height(self, points: NDArray[np.floating]) -> Heights:
        """Return the height of the ground, (…,) m, below points, (…, 2 or more) m.

        Only x and y of the points matter. Each square is divided into triangles along the diagonal
        from its first corner, as in MuJoCo.
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
