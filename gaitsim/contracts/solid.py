"""The rigid solids that a body is made of, for pictures."""

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

Shape = Literal["box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"]

_SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "mesh": 0}


class SkeletonError(ValueError):
    """The parts of a skeleton do not fit each other."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid convex solid in its own frame; `Skeleton.poses` places it in the world.

    Args:
        name: the part that it belongs to. A name that begins with L or R and a number, left or
            right, as in 'L1 tibia', has the colour of that side.
        shape: one of box, sphere, capsule, cylinder, ellipsoid, mesh.
        size: metres, as MuJoCo has it: three half lengths of a box along x, y and z; the radius
            of a sphere; the radius of a capsule or cylinder, and half its length along z, without
            a capsule's round ends; three radii of an ellipsoid; nothing for a mesh.
        vertices: points of a mesh, (points, 3), metres: it is their convex hull.

    Raises:
        SkeletonError: there is no such shape, or size and vertices do not fit it.
    """

    name: str
    shape: Shape
    size: tuple[float, ...] = ()
    vertices: NDArray[np.floating[Any]] | None = None

    def __post_init__(self) -> None:
        if self.shape not in get_args(Shape):
            raise SkeletonError(
                f"solid {self.name!r} has the shape {self.shape!r}, "
                f"expected one of {', '.join(get_args(Shape))}"
            )
        count = _SIZES[self.shape]
        if np.shape(self.size) != (count,) or not all(0 < length < np.inf for length in self.size):
            expected = f"{count} lengths above 0" if count else "nothing"
            raise SkeletonError(
                f"solid {self.name!r}, a {self.shape}, has the size {self.size}, "
                f"expected {expected}"
            )
        if (self.shape == "mesh") != (self.vertices is not None):
            raise SkeletonError(
                f"solid {self.name!r} is a {self.shape}: a mesh, and no other shape, has vertices"
            )
        points = self.vertices
        if points is None:
            return
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
            raise SkeletonError(
                f"solid {self.name!r} has vertices of shape {points.shape}, expected "
                "(points, 3), 4 points or more"
            )
        if not np.isfinite(points).all():
            raise SkeletonError(f"solid {self.name!r} has vertices that are not finite")
