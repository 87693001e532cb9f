"""The ground below a body's path, as a mesh of tiles in two shades."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Terrain
from gaitsim.render.meshes import Mesh
from gaitsim.render.scene.camera import Points
from gaitsim.render.scene.clip import Clip
from gaitsim.render.scene.ground import steps

TILES = 40  # maximum number of tiles along the longer side


def ground(clip: Clip) -> tuple[Mesh, NDArray[np.intp]]:
    """Return the ground, with a margin of one body length around the path.

    Uneven ground includes its own corners, and extends its edges horizontally beyond them.

    Returns:
        A mesh of the tiles of one shade, and the triangles of the other shade.
    """
    path, span = np.asarray(clip.skeleton.path, dtype=np.float64)[:, :2], clip.anatomy.span
    low, high = path.min(axis=0) - span, path.max(axis=0) + span
    step = steps(float((high - low).max()) / TILES)[0]
    # Additional lines would split the triangles of a terrain.
    tiled = not isinstance(clip.skeleton.ground, Terrain)
    x, y = (
        _lines(low[axis], high[axis], step if tiled else np.inf, clip.corners[axis])
        for axis in (0, 1)
    )
    points = clip.on_ground(np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1))
    if clip.skeleton.ground is None:
        points[..., 2] = clip.floor
    first = (np.arange(len(y) - 1)[:, None] * len(x) + np.arange(len(x) - 1)).ravel()
    across, beside = first + len(x) + 1, first + 1
    pairs = np.stack([first, beside, across, first, across, first + len(x)], axis=1)
    corner, opposite = points.reshape(-1, 3)[first], points.reshape(-1, 3)[across]
    tile = np.floor((corner + opposite)[:, :2] / 2 / step).astype(np.intp)
    dark = tile.sum(axis=1) % 2 == 1
    light, other = (pairs[one].reshape(-1, 3) for one in (~dark, dark))
    return Mesh(points.reshape(-1, 3), light), other


def _lines(low: float, high: float, step: float, corners: Points) -> Points:
    """Return the positions of tile edges and corners of the ground along an axis, m."""
    inside = corners[(low < corners) & (corners < high)]
    edges = np.empty(0)
    if np.isfinite(step):
        edges = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
    lines = np.unique(np.concatenate([[low, high], edges, inside]))
    # Edges that differ only by rounding would enclose empty tiles.
    return np.asarray(lines[np.concatenate([[True], np.diff(lines) > 1e-9 * (high - low)])])
