"""Rigid solids for drawing bodies."""

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

Shape = Literal["box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"]

_SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "mesh": 0}


class SkeletonError(ValueError):
    """Raised if the parts of a skeleton or a rig do not match each other."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid convex solid in its own frame; `Skeleton.poses` gives its place in the world.

    Args:
        name: name of the part of the body. If its first word, without a number, is L, R, left,
            right, near or far, as in 'L1 tibia', the solid has the colour of that side.
        shape: one of box, sphere, capsule, cylinder, ellipsoid, mesh.
        size: lengths in metres, as in MuJoCo. Box: half lengths along x, y and z. Sphere: radius.
            Capsule and cylinder: radius, and half length along z, without the round ends of a
            capsule. Ellipsoid: three radii. Mesh: ().
        vertices: points of a mesh, (points, 3), metres; the solid is their convex hull.

    Raises:
        SkeletonError: the shape is unknown, or `size` or `vertices` do not match it.
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
            expected = f"{count} lengths above 0" if count else "()"
            raise SkeletonError(
                f"solid {self.name!r}, a {self.shape}, has the size {self.size}, "
                f"expected {expected}"
            )
        if (self.shape == "mesh") != (self.vertices is not None):
            raise SkeletonError(
                f"solid {self.name!r} is a {self.shape}: a mesh must have vertices, and no other "
                "shape may"
            )
        points = self.vertices
        if points is None:
            return
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
            raise SkeletonError(
                f"solid {self.name!r} has vertices of shape {points.shape}, expected "
                "(points, 3) with at least 4 points"
            )
        if not np.isfinite(points).all():
            raise SkeletonError(f"solid {self.name!r} has vertices that are not finite")
