"""Rotations over time, as unit quaternions (x, y, z, w) in the order of glTF and SciPy."""

import numpy as np

from gaitsim.render.scene.camera import Points


def without_sign_flips(quaternions: Points) -> Points:
    """Return quaternions (frames, …, 4) whose signs do not flip between frames."""
    turns = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=-1) < 0, -1.0, 1.0)
    signs = np.concatenate([np.ones_like(quaternions[:1, ..., 0]), np.cumprod(turns, axis=0)])
    return np.asarray(quaternions * signs[..., None])


def rotations_from_z(directions: Points) -> Points:
    """Return the rotations that align the z axis with directions, without twist between frames.

    Args:
        directions: unit vectors (frames, rods, 3); a rod of zero length, without a direction,
            keeps its rotation.

    Returns:
        The rotations, (frames, rods, 4).
    """
    from scipy.spatial.transform import Rotation

    axis = np.array([0.0, 0.0, 1.0])
    turn = Rotation.identity(directions.shape[1])
    found = np.empty((*directions.shape[:2], 4))
    for frame, wanted in enumerate(directions):
        turn = Rotation.from_quat(_arc(turn.apply(axis), wanted)) * turn
        found[frame] = turn.as_quat()
    return without_sign_flips(found)


def _arc(one: Points, other: Points) -> Points:
    """Return the shortest rotations (…, 4) from unit vectors (…, 3) to others."""
    cosine = (one * other).sum(axis=-1, keepdims=True)
    arc = np.concatenate([np.cross(one, other), 1 + cosine], axis=-1)
    # Opposite vectors need half a turn about a perpendicular axis.
    nearest = np.eye(3)[np.abs(one).argmin(axis=-1)]
    half = np.concatenate([np.cross(one, nearest), np.zeros_like(cosine)], axis=-1)
    return np.where(np.linalg.norm(arc, axis=-1, keepdims=True) < 1e-6, half, arc)


def rigid_rotations(places: Points) -> Points | None:
    """Return the rotations of points about the origin since the first frame (Kabsch 1976).

    Args:
        places: positions of the points, (frames, points, 3) m.

    Returns:
        The rotations, (frames, 4); None if the points are not rigid, or all on one line.
    """
    from scipy.spatial.transform import Rotation

    first = places[0]
    left, sizes, right = np.linalg.svd(np.einsum("fpi,pj->fij", places, first))
    if (sizes[:, 1] <= 1e-6 * sizes[:, 0]).any():
        return None
    left[..., 2] *= np.linalg.det(left @ right)[:, None]
    matrices = left @ right
    away = np.einsum("fij,pj->fpi", matrices, first) - places
    if np.abs(away).max() > 1e-4 * np.abs(first).max():
        return None
    return without_sign_flips(Rotation.from_matrix(matrices).as_quat())
