"""Conditions that vary between the worlds that a body moves in, such as friction and terrain."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, unknown

WORLD_HELP = (
    "conditions of the body's world by name, such as friction = 0.4; the others are nominal. The "
    "key seed, a whole number, determines everything random in the world"
)
SEED = "seed"
"""Key of the seed of a world's random choices, such as the sign of a joint's error."""


@dataclass(frozen=True)
class Condition:
    """A quantity that varies between worlds.

    Attributes:
        unit: unit as printed, '' for a pure number.
        nominal: value in a world that does not name the condition.
        low: lower end of the usual range.
        high: upper end of the usual range.
        least: smallest value that the body supports.
        most: largest value that the body supports.
        help: description of the condition, one phrase.
        drawn: whether it varies between drawn worlds if an experiment names no ranges.
    """

    unit: str
    nominal: float
    low: float
    high: float
    least: float
    most: float
    help: str
    drawn: bool = True

    def table_cells(self) -> tuple[str, str, str, str]:
        """Return the nominal value, usual range, unit and description as strings for a table."""
        note = "" if self.drawn else "; varies only if ranges name it"
        return f"{self.nominal:g}", f"{self.low:g} to {self.high:g}", self.unit, self.help + note

    def __str__(self) -> str:
        span = f"{self.low:g} to {self.high:g} {self.unit}".rstrip()
        return f"{self.help}; nominal {self.nominal:g}, usually {span}"


def check_world(world: Mapping[str, float], conditions: Mapping[str, Condition]) -> None:
    """Validate the option `world` of a body.

    Args:
        world: values by name of the condition, and optionally a `seed`.
        conditions: conditions of the body by name.

    Raises:
        GaitsimError: a name is unknown, a value is outside the range that the body supports, or
            the seed is invalid.
    """
    for name, value in world.items():
        if name == SEED:
            if not (value == math.floor(value) and 0 <= value < 2**53):
                raise GaitsimError(
                    f"invalid seed of a world: {value:g}",
                    key="world",
                    allowed="a whole number from 0 to 2^53 − 1",
                )
            continue
        if name not in conditions:
            raise unknown("condition", name, [*conditions, SEED], key="world")
        condition = conditions[name]
        if not condition.least <= value <= condition.most:
            raise GaitsimError(
                f"invalid value of the condition {name!r}: {value:g}",
                key="world",
                allowed=f"{condition.least:g} to {condition.most:g} {condition.unit}".rstrip(),
            )


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

    def near(self, points: NDArray[np.floating], margin: float) -> "Terrain":
        """Return the part of the terrain within a distance of points, in x and in y.

        Args:
            points: points, (…, 2 or more) m; only x and y matter.
            margin: distance, m.
        """
        places = points[..., :2].reshape(-1, 2) - self.corner
        last = np.array(self.heights.shape[::-1]) - 1
        first = np.floor((places.min(axis=0) - margin) / self.spacing)
        end = np.ceil((places.max(axis=0) + margin) / self.spacing)
        left, low = np.clip(first, 0, last - 1).astype(int).tolist()
        right, high = np.clip(end, (left + 1, low + 1), last).astype(int).tolist()
        x, y = self.corner
        corner = (x + self.spacing * left, y + self.spacing * low)
        return Terrain(self.heights[low : high + 1, left : right + 1], self.spacing, corner)

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
