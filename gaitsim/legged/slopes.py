"""Slopes: the direction of gravity relative to the ground, and drawings of inclined ground.

Bodies move in a frame that is fixed to the ground; a slope tilts gravity instead.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton, Terrain
from gaitsim.contracts.quaternions import conjugate, product, rotated
from gaitsim.portable import cos, sin

FAR = 1e3  # m, distance to the edge of a slope


def downward(world: Mapping[str, float]) -> NDArray[np.float64]:
    """Return the direction of gravity relative to the ground of a world, (3,).

    Args:
        world: values by the names of conditions. `slope` is the angle of the x axis above the
            horizontal, °; `side_slope` is the rotation about the x axis that raises the y axis, °.
    """
    return _downward(world.get("slope", 0.0), world.get("side_slope", 0.0))


@lru_cache  # 0.1 ms for each part of a population otherwise
def _downward(slope: float, side_slope: float) -> NDArray[np.float64]:
    along, aside = np.radians([slope, side_slope])
    down = -np.array([sin(along), cos(along) * sin(aside), cos(along) * cos(aside)])
    down.setflags(write=False)
    return down


def place_on_slope(
    skeleton: Skeleton, world: Mapping[str, float], bumps: Terrain | None = None
) -> Skeleton:
    """Rotate a skeleton by the slope of a world about the start, and add the ground.

    Args:
        skeleton: skeleton on ground whose normal is the z axis.
        world: values by the names of conditions.
        bumps: uneven ground relative to the slope.
    """
    turn = _turn(world.get("slope", 0.0), world.get("side_slope", 0.0))
    if turn[0] == 1:
        return replace(skeleton, ground=bumps)
    poses = skeleton.poses
    if poses is not None:
        placed = np.asarray(poses, np.float64)
        turned = rotated(turn, placed[..., :3]), product(turn, placed[..., 3:])
        poses = np.concatenate(turned, axis=-1)
    return replace(
        skeleton,
        segments=rotated(turn, np.asarray(skeleton.segments)),
        contacts=rotated(turn, np.asarray(skeleton.contacts)),
        centre=rotated(turn, np.asarray(skeleton.centre)),
        poses=poses,
        ground=_inclined_terrain(turn, bumps),
    )


def _turn(slope: float, side_slope: float) -> NDArray[np.float64]:
    """Return the rotation of the ground by slopes in degrees, a quaternion (4,)."""
    up, left = np.radians([-slope, side_slope]) / 2
    along = np.array([cos(up), 0.0, sin(up), 0.0])
    return product(along, np.array([cos(left), sin(left), 0.0, 0.0]))


def _inclined_terrain(turn: NDArray[np.float64], bumps: Terrain | None) -> Terrain:
    """Return a slope as terrain, with vertical bumps."""
    lattice = bumps or Terrain(np.zeros((2, 2)), 2 * FAR, (-FAR, -FAR))
    normal = rotated(turn, np.array([0.0, 0.0, 1.0]))
    places = np.stack([*np.meshgrid(*lattice.corners), np.zeros(lattice.heights.shape)], axis=-1)
    places[..., 2] = -(places[..., 0] * normal[0] + places[..., 1] * normal[1]) / normal[2]
    rise = lattice.height(rotated(conjugate(turn), places)) / normal[2]
    return replace(lattice, heights=places[..., 2] + rise)
