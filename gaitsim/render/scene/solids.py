"""Outlines of limbs, plates and discs, and the surfaces of a skeleton's solids.

The surfaces are polygons of boxes and meshes, and quadrics of round shapes.
"""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Solid
from gaitsim.gait.travel import convex_hull
from gaitsim.render.scene.camera import Points

_ARC = np.linspace(-np.pi / 2, np.pi / 2, 12)  # a round end
_CIRCLE = np.linspace(0, 2 * np.pi, 25)[:-1]

FINE = 2  # samples per pixel in each direction, to smooth edges; `to_pixels` adds 2 × 2
SHADES = 64  # shades of a solid; the first is for its outline
BIAS = 1e-4  # least relative difference of depth; ties go to the first surface


class Drawn(NamedTuple):
    """The visible surface at each sample of a part of the picture, from the lowest row up.

    Attributes:
        left, bottom: lower left corner of the part, whole pixels.
        nearness: 1 / depth, 0 for the background, (rows, columns) 1/m.
        paint: (1 + index of the solid) × `SHADES` + shade; 0 for the background.
        piece: distinct number for each piece that has an outline.
    """

    left: int
    bottom: int
    nearness: NDArray[np.float32]
    paint: NDArray[np.int32]
    piece: NDArray[np.int32]


def capsules(ends: Points, radii: Points) -> Points:
    """Outline tapered limbs with round ends.

    Args:
        ends: (limbs, 2, 2) pixels.
        radii: (limbs, 2) pixels.

    Returns:
        The outlines, (limbs, corners, 2) pixels.
    """
    along = ends[:, 1] - ends[:, 0]
    angle = np.arctan2(along[:, 1], along[:, 0])
    turn = angle[:, None, None] + np.stack([_ARC + np.pi, _ARC])  # (limbs, 2, arc)
    arcs = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * radii[:, :, None, None]
    return (ends[:, :, None] + arcs).reshape(len(ends), 2 * len(_ARC), 2)


def discs(centres: Points, radius: float) -> Points:
    """Outline circles on the ground around centres (discs, 3); return (discs, corners, 3), m."""
    circle = np.zeros((len(_CIRCLE), 3))
    circle[:, 0], circle[:, 1] = np.cos(_CIRCLE), np.sin(_CIRCLE)
    return np.asarray(centres[:, None] + radius * circle)


def hull(points: Points) -> Points:
    """Return the corners of the convex hull of (points, 2) in order; none if it has no area."""
    corners = convex_hull(points)
    return corners if len(corners) > 2 else points[:0]


def outlines(points: Points, starts: NDArray[np.intp]) -> Points:
    """Return approximate convex hulls of groups of points: the farthest in 24 directions.

    For the 160 points of a capsule it takes a tenth of the time of `hull`.

    Args:
        points: points of all groups, (points, 2).
        starts: index of each group's first point, and the number of points, (groups + 1,).

    Returns:
        The outlines, (groups, corners, 2).
    """
    away = points @ np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])
    farthest = [first + away[first:end].argmax(axis=0) for first, end in pairwise(starts)]
    return np.asarray(points[np.array(farthest)])


def hull_faces(points: Points) -> list[NDArray[np.intp]]:
    """Return the faces of the convex hull of (points, 3); none if it has no volume.

    Returns:
        The indices of each face's corners, counter-clockwise from outside.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        return []
    faces = []
    for plane in np.unique(np.round(hull.equations, 6), axis=0):
        triangles = hull.simplices[(np.abs(hull.equations - plane) < 1e-5).all(axis=1)]
        corners = np.unique(triangles)
        away = points[corners] - points[corners].mean(axis=0)
        across = np.cross(plane[:3], away[0])
        order = np.argsort(np.arctan2(away @ across, away @ away[0]))
        faces.append(corners[order])
    return faces


CREASED = 12  # maximum faces of a mesh with inked edges; others are assumed to be round
SHEET = 0.001  # half the thickness of a flat mesh, relative to its length
_AROUND = np.linspace(0, 2 * np.pi, 17)[:-1]


class Round(NamedTuple):
    """A quadric |(x − centre) · inverse| ≤ 1 between two planes |z − centre| ≤ half.

    Attributes:
        centre: (3,) m.
        inverse: inverses of the radii, (3,) 1/m; 0 along the axis of a cylinder.
        half: half the length along z, m; infinite if no plane cuts the quadric.
        own: slice of the solid's points that span the quadric.
    """

    centre: Points
    inverse: Points
    half: float
    own: slice = slice(None)


class Surface(NamedTuple):
    """A solid's surface in its own frame.

    Attributes:
        points: points that approximately span the surface, (points, 3) m.
        creased: whether the edges between faces are visible.
        rounds: round pieces, which overlap in a capsule.
        faces: indices of the points at the corners of each flat face, counter-clockwise from
            outside.
        places: a point on each face, (faces, 3) m.
        normals: outward normal of each face, unit vectors (faces, 3).
    """

    points: Points
    creased: bool
    rounds: tuple[Round, ...] = ()
    faces: Sequence[NDArray[np.intp]] = ()
    places: Points = np.empty((0, 3))
    normals: Points = np.empty((0, 3))


def surface(solid: Solid) -> Surface:
    """Return the surface of a solid."""
    size = np.array(solid.size, dtype=np.float64)
    if solid.vertices is not None:
        return _polyhedron(solid.vertices.astype(np.float64))
    if solid.shape == "box":
        return _polyhedron(_CUBE * size)
    if solid.shape in ("sphere", "ellipsoid"):
        radii = np.broadcast_to(size, 3)
        return Surface(_BALL * radii, False, (Round(np.zeros(3), 1 / radii, np.inf),))
    radius, half = size
    ends = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    rod = Round(np.zeros(3), np.array([1 / radius, 1 / radius, 0.0]), half)
    if solid.shape == "cylinder":
        return Surface(np.concatenate([radius * _RING + end for end in ends]), True, (rod,))
    spans = slice(len(_BALL)), slice(len(_BALL), None)
    balls = [Round(ends[i], np.full(3, 1 / radius), np.inf, spans[i]) for i in (0, 1)]
    points = np.concatenate([radius * _BALL + end for end in ends])
    return Surface(points, False, (rod, *balls))


def _polyhedron(points: Points) -> Surface:
    faces = hull_faces(points)
    if not faces:  # a flat mesh gets the thickness of a sheet
        size = max(float(np.ptp(points, axis=0).max()), 1e-6)
        points = (points + size * SHEET * _CUBE[:, None]).reshape(-1, 3)
        faces = hull_faces(points)
    first, second, third = (points[[face[i] for face in faces]] for i in range(3))
    normals = np.cross(second - first, third - first)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Surface(points, len(faces) <= CREASED, (), faces, first, normals)


def _ring_at(height: float) -> Points:
    """Return a ring of points at a height on the unit sphere, (points, 3)."""
    across = np.sqrt(1 - height**2)
    ring = [across * np.cos(_AROUND), across * np.sin(_AROUND), np.full(len(_AROUND), height)]
    return np.stack(ring, axis=1)


_CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
_RING = _ring_at(0.0)
_BALL = np.concatenate([_ring_at(height) for height in (-1, -0.7, 0, 0.7, 1)])


class Pieces(NamedTuple):
    """The flat faces and round pieces of all solids.

    Attributes:
        creased: whether the edges between the pieces of each solid are visible, (solids,).
        faces: index of each solid's first face, and the number of faces, (solids + 1,).
        places: a point on each face in the frame of its solid, (faces, 3) m.
        normals: outward normal of each face, unit vectors (faces, 3).
        corners: index of each face's first corner, and the number of corners, (faces + 1,).
        points: index of the point at each corner, (corners,).
        rounds: index of each solid's first round piece, and their number, (solids + 1,).
        centres, inverses, halves: see `Round`.
        spans: first and last + 1 of the points that span each round piece, (rounds, 2).
    """

    creased: NDArray[np.bool_]
    faces: NDArray[np.int64]
    places: Points
    normals: Points
    corners: NDArray[np.int64]
    points: NDArray[np.int64]
    rounds: NDArray[np.int64]
    centres: Points
    inverses: Points
    halves: Points
    spans: NDArray[np.int64]


class Surfaces:
    """The surfaces of all solids of a body.

    Attributes:
        each: surface of each solid.
        points: points of all surfaces, solid by solid, in the frame of the solid, (points, 3) m.
        owner: index of the solid of each point, (points,).
        starts: index of each solid's first point, and the number of points, (solids + 1,).
    """

    def __init__(self, solids: Sequence[Solid]) -> None:
        self.each = [surface(solid) for solid in solids]
        counts = [len(one.points) for one in self.each]
        self.starts: NDArray[np.intp] = np.cumsum([0, *counts])
        self.points = np.concatenate([np.empty((0, 3)), *(one.points for one in self.each)])
        self.owner: NDArray[np.intp] = np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def pieces(self) -> Pieces:
        """The faces and round pieces of all solids."""
        numbered = list(zip(self.starts.tolist(), self.each, strict=False))
        faces = [start + face for start, one in numbered for face in one.faces]
        rounds = [piece for one in self.each for piece in one.rounds]
        spans = [
            [start + end for end in piece.own.indices(len(one.points))[:2]]
            for start, one in numbered
            for piece in one.rounds
        ]
        return Pieces(
            np.array([one.creased for one in self.each]),
            np.cumsum([0, *(len(one.faces) for one in self.each)]),
            np.concatenate([one.places for one in self.each]),
            np.concatenate([one.normals for one in self.each]),
            np.cumsum([0, *map(len, faces)]),
            np.concatenate([np.empty(0, dtype=np.int64), *faces]),
            np.cumsum([0, *(len(one.rounds) for one in self.each)]),
            np.array([piece.centre for piece in rounds]).reshape(-1, 3),
            np.array([piece.inverse for piece in rounds]).reshape(-1, 3),
            np.array([piece.half for piece in rounds]),
            np.array(spans, dtype=np.int64).reshape(-1, 2),
        )

    def points_at(self, poses: Points) -> Points:
        """Return the points (…, points, 3) in the world at poses (…, solids, 7), m."""
        turns = rotations(poses[..., 3:]).swapaxes(-1, -2)
        placed = [
            one.points @ turns[..., solid, :, :] + poses[..., solid, None, :3]
            for solid, one in enumerate(self.each)
        ]
        return np.concatenate([np.empty((*poses.shape[:-2], 0, 3)), *placed], axis=-2)


def rotations(quaternions: Points) -> Points:
    """Return the rotation matrices (…, 3, 3) of unit quaternions (w, x, y, z), (…, 4)."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def interpolate_poses(one: Points, other: Points, share: float) -> Points:
    """Interpolate between two poses (solids, 7); a share of 0 gives the first, 1 the second."""
    nearer = np.where((one[:, 3:] * other[:, 3:]).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    other = np.concatenate([other[:, :3], nearer * other[:, 3:]], axis=1)
    found = one + share * (other - one)
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
    return found
