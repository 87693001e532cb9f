"""Draw solids pixel by pixel, so that intersecting parts are shown correctly.

Each pixel keeps the surface with the largest w = 1 / depth. As a function of the position in the
picture, the w of a plane is affine, and the w of a quadric is the root of a quadratic equation.
"""

import numpy as np

from gaitsim.render.scene.camera import NEAR, Camera, Points
from gaitsim.render.scene.solids import FINE, SHADES, Drawn, Surfaces, rotations


def raster(
    camera: Camera,
    surfaces: Surfaces,
    poses: Points,
    light: Points,
    picture: tuple[int, int],
    margin: int,
) -> Drawn | None:
    """Draw solids.

    Args:
        camera: camera of the picture.
        surfaces: surfaces of the solids.
        poses: poses of the solids, (solids, 7).
        light: direction to the light, a unit vector, (3,).
        picture: width and height of the picture, pixels.
        margin: margin around the solids, pixels.

    Returns:
        The visible surfaces; None if no solid is in the picture.
    """
    from gaitsim.render.scene.kernels import fill

    points = surfaces.points_at(poses)
    flat, depth = camera.project(points)
    low, high = flat.min(axis=0), flat.max(axis=0)
    # The points of a round solid lie on its surface, so the outline bulges between them.
    swell = 0.02 * (high - low) + margin + 1
    (left, bottom), (right, top) = (
        np.clip(np.floor(low - swell), 0, picture).astype(int).tolist(),
        np.clip(np.ceil(high + swell), 0, picture).astype(int).tolist(),
    )
    if left >= right or bottom >= top:
        return None
    shape = (top - bottom) * FINE, (right - left) * FINE
    drawn = Drawn(
        left,
        bottom,
        np.zeros(shape, dtype=np.float32),
        np.zeros(shape, dtype=np.int32),
        np.zeros(shape, dtype=np.int32),
    )
    nearest = np.full(len(surfaces.each), np.inf)
    np.minimum.at(nearest, surfaces.owner, depth)
    corner = (np.array([left, bottom]) - camera.centre) / (camera.scale * camera.distance)
    step = 1 / (FINE * camera.scale * camera.distance)
    eye = camera.target - camera.distance * camera.ahead
    axes = np.stack([camera.right, camera.up, camera.ahead])
    start = axes.T @ (*(corner + step / 2), 1.0)  # the ray of the first sample
    vectors = np.empty((len(poses), 5, 3))
    vectors[:, 0] = eye - poses[:, :3]
    vectors[:, 1:] = step * camera.right, step * camera.up, start, light
    frames = vectors @ rotations(poses[:, 3:])
    shown = nearest > NEAR * camera.distance * 1.001
    fill(drawn, surfaces.pieces, (flat - (left, bottom)) * FINE, frames, shown)
    return drawn


def shades_of(dark: Points, light: Points, ink: Points) -> Points:
    """Return the colours of solids, (solids, `SHADES`, 3): the outline, then dark to light."""
    share = np.linspace(0, 1, SHADES - 1)[:, None]
    return np.concatenate([ink[:, None], dark[:, None] * (1 - share) + light[:, None] * share], 1)
