"""The ground of a robot: level, or with bumps of random height."""

import math
from typing import Any

import numpy as np

from gaitsim.contracts import Terrain
from gaitsim_robot.anatomy import Anatomy

GROUND = "world: ground"  # a name that no geom of a robot is likely to have
HIGHEST = 0.2  # m, of bumps
SPACING = 0.5  # of corners, in lengths of the trunk: the feet of a stride meet different ones
FASTEST = 4.0  # lengths of the trunk a second: twice as fast as the bundled robots walk
BASE = 0.1  # m, of solid ground below z = 0


def corners_for(seconds: float) -> int:
    """Return how many corners bumpy ground has each way for a robot that walks for a time, s."""
    return math.ceil(FASTEST * seconds / SPACING) + 4


def add_ground(spec: Any, anatomy: Anatomy, corners: int, friction: float) -> None:
    """Add the ground to a specification: a plane, or a height field that is level as yet.

    Args:
        spec: changed in place.
        anatomy: of the robot.
        corners: of the height field each way from the middle; 0 for a plane.
        friction: of the ground.
    """
    import mujoco

    kind, size, field = mujoco.mjtGeom.mjGEOM_PLANE, [0.0, 0.0, 1.0], {}
    if corners:
        half, side = corners * SPACING * anatomy.length, 2 * corners + 1
        kind, size, field = mujoco.mjtGeom.mjGEOM_HFIELD, [0.0, 0.0, 0.0], {"hfieldname": GROUND}
        spec.add_hfield(
            name=GROUND,
            size=[half, half, HIGHEST, BASE],
            nrow=side,
            ncol=side,
            userdata=np.zeros(side**2),
        )
    spec.worldbody.add_geom(
        name=GROUND, type=kind, size=size, friction=[friction, 0.005, 0.0001], **field
    )


def raise_bumps(model: Any, unevenness: float, seed: int, level: float) -> Terrain:
    """Give the height field of a robot's model heights drawn uniformly from 0 to `unevenness`.

    Args:
        model: `mujoco.MjModel`, changed in place.
        unevenness: height of the highest corner, m.
        seed: of the heights; the same seed draws the same ones for any number of corners.
        level: distance from the middle up to which there are none, m.
    """
    corners = int(model.hfield_nrow[0]) // 2
    half = float(model.hfield_size[0, 0])
    outward = np.abs(np.mgrid[-corners : corners + 1, -corners : corners + 1]).max(axis=0)
    shares = np.empty(outward.size, np.float32)
    drawn = np.random.default_rng([seed, 0]).uniform(0.0, unevenness, outward.size)
    shares[np.argsort(outward.ravel(), kind="stable")] = drawn / HIGHEST
    spacing = half / corners
    shares[spacing * (outward.ravel() - 1) <= level] = 0.0
    model.hfield_data[:] = shares
    heights = HIGHEST * shares.astype(np.float64).reshape(outward.shape)
    return Terrain(heights, spacing, (-half, -half))
