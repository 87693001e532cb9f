"""The ground of a robot: level, or with bumps of random height."""

import math
from typing import Any

import numpy as np

from gaitsim.contracts import Terrain
from gaitsim_robot.anatomy import Anatomy

GROUND = "world: ground"  # a name that geoms of robots are unlikely to have
HIGHEST = 0.2  # m, height of the highest possible bump
SPACING = 0.5  # trunk lengths between corners, so that the feet step on different ones
FASTEST = 4.0  # trunk lengths per second, twice the speed of the bundled robots
BASE = 0.1  # m, thickness of solid ground below z = 0


def corners_for(seconds: float) -> int:
    """Return the number of corners in each direction for a walk of a given duration, s."""
    return math.ceil(FASTEST * seconds / SPACING) + 4


def add_ground(spec: Any, anatomy: Anatomy, corners: int, friction: float) -> None:
    """Add the ground to a specification: a plane, or a height field that is still level.

    Args:
        spec: MuJoCo's specification, changed in place.
        anatomy: anatomy of the robot.
        corners: number of corners of the height field in each direction from the middle; 0 for a
            plane.
        friction: friction of the ground.
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
    """Set the heights of a model's height field, drawn uniformly from 0 to `unevenness`.

    Args:
        model: `mujoco.MjModel`, changed in place.
        unevenness: upper bound of the heights, m.
        seed: seed of the heights, which draws the same heights for any number of corners.
        level: distance from the middle up to which the ground is level, m.
    """
    corners = int(model.hfield_nrow[0]) // 2
    half = float(model.hfield_size[0, 0])
    outward = np.abs(np.mgrid[-corners : corners + 1, -corners : corners + 1]).max(axis=0)
    shares = np.empty(outward.size, np.float32)
    drawn = unevenness * np.random.default_rng([seed, 0]).random(outward.size)
    shares[np.argsort(outward.ravel(), kind="stable")] = drawn / HIGHEST
    spacing = half / corners
    shares[spacing * (outward.ravel() - 1) <= level] = 0.0
    model.hfield_data[:] = shares
    heights = HIGHEST * shares.astype(np.float64).reshape(outward.shape)
    return Terrain(heights, spacing, (-half, -half))
