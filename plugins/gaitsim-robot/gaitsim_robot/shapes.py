"""The surface of a robot as points and balls that can touch the ground."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.anatomy import Floats

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
"""Corners of a box with half lengths of 1, (8, 3)."""


@dataclass(frozen=True, eq=False)
class RobotSurface:
    """Points of all geoms that collide with the ground, each the middle of a ball.

    Attributes:
        geoms: index of the geom of each point, (points,).
        bodies: index of the body of each point, (points,).
        local: positions in the frame of the geom, (points, 3) m.
        radius: radius of each ball, (points,) m; 0 for a point.
    """

    geoms: NDArray[np.intp]
    bodies: NDArray[np.intp]
    local: Floats
    radius: Floats

    def place(self, data: Any) -> Floats:
        """Return the points in the world, (points, 3) m."""
        turned = np.einsum("pij,pj->pi", data.geom_xmat[self.geoms].reshape(-1, 3, 3), self.local)
        placed: Floats = data.geom_xpos[self.geoms] + turned
        return placed

    def points_on(self, bodies: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return the indices of the points on given bodies."""
        return np.flatnonzero(np.isin(self.bodies, bodies))


def surfaces(model: Any) -> RobotSurface:
    """Return the surfaces of a compiled robot."""
    geoms, local, radius = [], [], []
    for geom in range(model.ngeom):
        if not (model.geom_contype[geom] | model.geom_conaffinity[geom]) & 1:
            continue  # the ground has bit 1
        points, ball = geom_surface(model, geom)
        geoms.append(np.full(len(points), geom, np.intp))
        local.append(points)
        radius.append(np.full(len(points), ball))
    if not geoms:
        empty = np.zeros(0, np.intp)
        return RobotSurface(empty, empty, np.zeros((0, 3)), np.zeros(0))
    owners = np.concatenate(geoms)
    return RobotSurface(owners, model.geom_bodyid[owners], np.vstack(local), np.concatenate(radius))


def geom_surface(model: Any, geom: int) -> tuple[Floats, float]:
    """Return the points of a geom's surface in its frame, (points, 3) m, and their radius, m."""
    import mujoco

    kinds = mujoco.mjtGeom
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == kinds.mjGEOM_SPHERE:
        return np.zeros((1, 3)), float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]]), float(size[0])
    if kind == kinds.mjGEOM_BOX:
        return size * CORNERS, 0.0
    if kind == kinds.mjGEOM_CYLINDER:
        angle = np.arange(16) * (math.pi / 8)
        ring = np.stack([np.cos(angle), np.sin(angle), np.ones(16)], axis=1)
        return np.vstack([ring, ring * [1, 1, -1]]) * [size[0], size[0], size[1]], 0.0
    if kind == kinds.mjGEOM_ELLIPSOID:
        return size * _sphere(200), 0.0
    if kind == kinds.mjGEOM_MESH:
        return mesh_vertices(model, geom), 0.0
    return np.zeros((1, 3)), 0.0


def mesh_vertices(model: Any, geom: int) -> Floats:
    """Return the vertices of a geom's mesh, (vertices, 3) m."""
    mesh = model.geom_dataid[geom]
    first = model.mesh_vertadr[mesh]
    vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
    return np.asarray(vertices, np.float64)


def _sphere(points: int) -> Floats:
    """Return a Fibonacci lattice on the unit sphere, and its six points on the axes."""
    index = np.arange(points) + 0.5
    height, turn = 1 - 2 * index / points, index * math.pi * (3 - math.sqrt(5))
    width = np.sqrt(1 - height * height)
    lattice = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    return np.vstack([lattice, np.eye(3), -np.eye(3)])
