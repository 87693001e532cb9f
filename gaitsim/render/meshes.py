"""Triangle meshes of rods, balls, plates and polyhedra, each in its own frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Solid
from gaitsim.render.scene.camera import Points
from gaitsim.render.scene.solids import surface

AROUND = 16  # number of corners of a circle
ARC = 5  # number of rings of a round end
_CIRCLE = np.linspace(0, 2 * np.pi, AROUND + 1)[:-1]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles between points.

    Attributes:
        points: (points, 3) m.
        triangles: indices of the corners, counter-clockwise from outside, (triangles, 3).
        normals: normals of the points, unit vectors (points, 3); None for flat triangles.
    """

    points: Points
    triangles: NDArray[np.intp]
    normals: Points | None = None


def rod(first: float, second: float, length: float) -> Mesh:
    """Return the convex hull of two balls on the z axis, half the length below and above 0.

    Args:
        first: radius of the lower ball, m.
        second: radius of the upper ball, m.
        length: distance of the centres, m.
    """
    # Angle between the xy plane and the normals of the cone that touches both balls.
    touching = np.arcsin(np.clip((first - second) / max(length, 1e-12), -1, 1))
    lower = np.linspace(-np.pi / 2, touching, ARC)
    upper = np.linspace(touching, np.pi / 2, ARC)
    angles = np.concatenate([lower, upper])
    radii = np.repeat([first, second], ARC)
    middles = np.repeat([-length / 2, length / 2], ARC)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return _revolve(radii[:, None] * normals + np.stack([0 * middles, middles], axis=1), normals)


def mesh_of(solid: Solid) -> Mesh:
    """Return the mesh of a solid."""
    size = solid.size
    if solid.shape == "capsule":
        return rod(size[0], size[0], 2 * size[1])
    if solid.shape in ("sphere", "ellipsoid"):
        ball, radii = rod(1.0, 1.0, 0.0), np.broadcast_to(np.array(size), 3)
        normals = np.asarray(ball.normals) / radii
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return Mesh(ball.points * radii, ball.triangles, normals)
    if solid.shape == "cylinder":
        radius, half = size
        outline = np.array([[0, -half], [radius, -half], [radius, -half], [radius, half]])
        outline = np.concatenate([outline, [[radius, half], [0, half]]])
        normals = np.repeat([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]], 2, axis=0)
        return _revolve(outline, normals)
    drawn = surface(solid)
    return polyhedron(drawn.points, drawn.faces)


def polyhedron(points: Points, faces: Sequence[Sequence[int] | NDArray[np.intp]]) -> Mesh:
    """Return a mesh of convex faces, given by the indices of their corners."""
    fans = [
        (face[0], face[i], face[i + 1])
        for face in map(list, faces)
        for i in range(1, len(face) - 1)
    ]
    used, places = np.unique(np.array(fans, dtype=np.intp), return_inverse=True)
    return Mesh(points[used], places.reshape(-1, 3))


def slab(corners: Points, half: float) -> Mesh:
    """Return a plate with straight edges.

    Args:
        corners: corners of the outline in order, (corners, 3) m.
        half: half the thickness, m.
    """
    count = len(corners)
    # Newell's normal, which tolerates outlines that are not exactly plane.
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    normal /= max(float(np.linalg.norm(normal)), 1e-30)
    middle = corners.mean(axis=0, keepdims=True)
    points = np.concatenate([corners, middle])
    points = np.concatenate([points + half * normal, points - half * normal])
    one = np.arange(count)
    following, below = np.roll(one, -1), count + 1
    top = np.stack([one, following, np.full(count, count)], axis=1)
    sides = np.stack([one, one + below, following, following, one + below, following + below], 1)
    return Mesh(points, np.concatenate([top, top[:, ::-1] + below, sides.reshape(-1, 3)]))


def _revolve(outline: Points, normals: Points) -> Mesh:
    """Revolve an outline, (rings, 2) as ascending radius and z in m, around the z axis."""
    circle = np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)

    def around(values: Points) -> Points:
        across = values[:, None, :1] * circle
        along = np.broadcast_to(values[:, None, 1:], (*across.shape[:2], 1))
        return np.concatenate([across, along], axis=2).reshape(-1, 3)

    ring = np.arange(AROUND)
    one = AROUND * np.arange(len(outline) - 1)[:, None] + ring
    other = AROUND * np.arange(len(outline) - 1)[:, None] + np.roll(ring, -1)
    quads = np.stack([one, other, other + AROUND, one, other + AROUND, one + AROUND], axis=-1)
    points, triangles = around(outline), quads.reshape(-1, 3)
    # Remove triangles without area, at poles or between coincident rings.
    sides = points[triangles[:, 1:]] - points[triangles[:, :1]]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    triangles = triangles[area > 1e-9 * area.max()]
    return Mesh(points, triangles, around(normals))
