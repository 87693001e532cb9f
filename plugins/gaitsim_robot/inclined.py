"""Drawings of robots on slopes and bumps."""

from dataclasses import replace

import numpy as np

from gaitsim.contracts import Skeleton, Terrain
from gaitsim.contracts.quaternions import conjugate, product, rotated
from gaitsim.portable import cos, sin
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.simulation import Simulation

FAR = 1e3  # m, distance to the edge of a slope


def place_on_ground(skeleton: Skeleton, simulation: Simulation) -> Skeleton:
    """Rotate a skeleton by the slope about the start, and add the ground.

    Args:
        skeleton: skeleton in the frame of the ground.
        simulation: simulation of the robot in its world.
    """
    turn = _turn(simulation.world.get("slope", 0.0), simulation.world.get("side_slope", 0.0))
    bumps = simulation.ground
    if bumps is not None:
        x, y = np.array(bumps.corner) - simulation.start[1:3]
        bumps = replace(bumps, corner=(float(x), float(y)))
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


def _turn(slope: float, side_slope: float) -> Floats:
    """Return the rotation of the ground by slopes in degrees, a quaternion (4,)."""
    up, left = np.radians([-slope, side_slope]) / 2
    along = np.array([cos(up), 0.0, sin(up), 0.0])
    return product(along, np.array([cos(left), sin(left), 0.0, 0.0]))


def _inclined_terrain(turn: Floats, bumps: Terrain | None) -> Terrain:
    """Return a slope as terrain, with vertical bumps."""
    lattice = bumps or Terrain(np.zeros((2, 2)), 2 * FAR, (-FAR, -FAR))
    normal = rotated(turn, np.array([0.0, 0.0, 1.0]))
    places = np.stack([*np.meshgrid(*lattice.corners), np.zeros(lattice.heights.shape)], axis=-1)
    places[..., 2] = -(places[..., :2] @ normal[:2]) / normal[2]
    rise = lattice.height(rotated(conjugate(turn), places)) / normal[2]
    return replace(lattice, heights=places[..., 2] + rise)
