"""The fly's points in homogeneous coordinates; M = T · R transforms them to the world frame.

In the body's frame, x points forward, y left and z up; the origin is the centre of mass. The left
wing is rotated about its hinge by Rx(flap) · Rz(−sweep) · Ry(−pitch); the right wing is its mirror
image.
"""

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import cos, matmul, sin

Floats = NDArray[np.float64]


def translation(offsets: Floats) -> Floats:
    """Return the homogeneous matrices (…, 4, 4) of translations (…, 3)."""
    matrices = np.broadcast_to(np.eye(4), (*offsets.shape[:-1], 4, 4)).copy()
    matrices[..., :3, 3] = offsets
    return matrices


def axis_rotation(axis: int, angles: Floats) -> Floats:
    """Return the homogeneous matrices (…, 4, 4) of rotations (…), rad, about axis 0, 1 or 2."""
    matrices = np.broadcast_to(np.eye(4), (*angles.shape, 4, 4)).copy()
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrices[..., first, first] = matrices[..., second, second] = cos(angles)
    matrices[..., second, first] = sin(angles)
    matrices[..., first, second] = -sin(angles)
    return matrices


def rotation(quaternions: Floats) -> Floats:
    """Return the homogeneous matrices (…, 4, 4) of unit quaternions w, x, y, z, (…, 4)."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    matrices = np.broadcast_to(np.eye(4), (*w.shape, 4, 4)).copy()
    matrices[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrices[..., 0, 1] = 2 * (x * y - w * z)
    matrices[..., 0, 2] = 2 * (x * z + w * y)
    matrices[..., 1, 0] = 2 * (x * y + w * z)
    matrices[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrices[..., 1, 2] = 2 * (y * z - w * x)
    matrices[..., 2, 0] = 2 * (x * z - w * y)
    matrices[..., 2, 1] = 2 * (y * z + w * x)
    matrices[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return matrices


def transform(matrices: Floats, points: Floats) -> Floats:
    """Apply homogeneous matrices (…, 4, 4) to points (…, points, 3)."""
    homogeneous = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)
    result: Floats = matmul(homogeneous, np.swapaxes(matrices, -1, -2))[..., :3]
    return result


def wing_matrix(angles: Floats, side: int, hinge: float) -> Floats:
    """Return the transformation from a wing's frame to the body's, (…, 4, 4).

    Args:
        angles: flap, pitch and sweep, (…, 3) rad; positive is up, leading edge up and forward.
        side: +1 for the left wing, −1 for the right wing.
        hinge: distance of the hinge from the middle of the body, m.
    """
    flap, pitch, sweep = np.moveaxis(angles, -1, 0)
    place = translation(np.array([0.0, side * hinge, 0.0]))
    turn = matmul(axis_rotation(0, side * flap), axis_rotation(2, -side * sweep))
    result: Floats = matmul(place, matmul(turn, axis_rotation(1, -pitch)))
    return result


def wing_points(side: int, span: float, chord: float) -> Floats:
    """Return a wing's triangle in its frame, (3, 3) m: the apex at the hinge, then the far edge."""
    return np.array(
        [[0.0, 0.0, 0.0], [chord / 2, side * span, 0.0], [-chord / 2, side * span, 0.0]]
    )


def cuboid(length: float, width: float, height: float) -> Floats:
    """Return the ends of a cuboid's edges, (12, 2, 3) m."""
    corners = np.array([[x, y, z] for x in (1, -1) for y in (1, -1) for z in (1, -1)], float)
    edges = [
        (a, b)
        for a in range(8)
        for b in range(a + 1, 8)
        if np.count_nonzero(corners[a] != corners[b]) == 1
    ]
    ends: Floats = corners[np.array(edges)] * np.array([length, width, height]) / 2
    return ends
