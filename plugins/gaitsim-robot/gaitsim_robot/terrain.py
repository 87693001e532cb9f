"""The ground of a robot: a plane, or a height field with bumps, steps and rubble."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Terrain
from gaitsim.plugin.toolkit import condition_rng, world_seed
from gaitsim_robot.anatomy import Anatomy, Floats

GROUND = "world: ground"  # a name that geoms of robots are unlikely to have
UNEVEN = ("unevenness", "steps", "rubble")
"""Conditions that make the ground uneven; their heights add up."""

HIGHEST = 0.2  # m, height of the highest possible bump, step or block
BASE = 0.1  # m, thickness of solid ground below its lowest point
FASTEST = 4.0  # trunk lengths per second, twice the speed of the bundled robots
LONGEST = 60.0  # s, of a fast walk on bumps; 4 MB in MuJoCo
BUMP = 0.5  # trunk lengths between corners of bumps, so that the feet step on different ones
EDGE = 0.1  # trunk lengths between corners of steps and rubble: the width of their edges
BLOCK = 5  # corners per block of rubble, in each direction
TERRACE = 10  # corners per terrace between steps
LEVELS = 2  # steps between the start and the highest or lowest terrace
MOST = 600  # corners of steps and rubble in each direction; 6 MB in MuJoCo


@dataclass(frozen=True)
class Lattice:
    """The lattice of a height field around the start.

    Attributes:
        corners: number of corners in each direction from the middle.
        spacing: distance between neighbouring corners, trunk lengths.
        lowest: lowest possible height, m.
        highest: highest possible height, m.
    """

    corners: int
    spacing: float
    lowest: float = 0.0
    highest: float = HIGHEST


def lattice_for(world: Mapping[str, float], seconds: float) -> Lattice | None:
    """Return the lattice of uneven ground for a walk; None for a level plane.

    Args:
        world: values of conditions by name.
        seconds: duration of the walk, s. Longer ones than `LONGEST` get the same ground, which fast
            robots can leave.
    """
    reach = FASTEST * min(seconds, LONGEST)
    if world.get("steps") or world.get("rubble"):
        corners = min(math.ceil(reach / EDGE) + 4, MOST)
        lowest = -LEVELS * HIGHEST
        # More than the sum of all conditions, so that MuJoCo's floats represent height 0 exactly.
        return Lattice(corners, EDGE, lowest, -3 * lowest)
    if world.get("unevenness"):
        return Lattice(math.ceil(reach / BUMP) + 4, BUMP)
    return None


def add_ground(spec: Any, anatomy: Anatomy, lattice: Lattice | None, friction: float) -> None:
    """Add the ground to a specification: a plane, or a height field without its heights.

    Args:
        spec: MuJoCo's specification, changed in place.
        anatomy: anatomy of the robot.
        lattice: lattice of the height field; None for a plane.
        friction: friction of the ground.
    """
    import mujoco

    kind, size, field = mujoco.mjtGeom.mjGEOM_PLANE, [0.0, 0.0, 1.0], {}
    if lattice:
        half, side = lattice.corners * lattice.spacing * anatomy.length, 2 * lattice.corners + 1
        kind, size = mujoco.mjtGeom.mjGEOM_HFIELD, [0.0, 0.0, 0.0]
        field = {"hfieldname": GROUND, "pos": [0.0, 0.0, lattice.lowest]}
        spec.add_hfield(
            name=GROUND,
            size=[half, half, lattice.highest - lattice.lowest, BASE],
            nrow=side,
            ncol=side,
            userdata=np.zeros(side**2),
        )
    spec.worldbody.add_geom(
        name=GROUND, type=kind, size=size, friction=[friction, 0.005, 0.0001], **field
    )


def raise_ground(model: Any, world: Mapping[str, float], level: float) -> Terrain:
    """Set the heights of a model's height field from a world's conditions and seed.

    The seed determines the same heights for any number of corners.

    Args:
        model: `mujoco.MjModel`, changed in place.
        world: values of conditions by name.
        level: distance from the middle up to which the ground is level, m.
    """
    corners = int(model.hfield_nrow[0]) // 2
    half, _, range_, _ = map(float, model.hfield_size[0])
    lowest, spacing = float(model.geom(GROUND).pos[2]), half / corners
    bumps, steps, rubble = (world.get(name, 0.0) for name in UNEVEN)
    if steps or rubble:
        heights = np.tile(steps * _terraces(world, corners, level / spacing), (2 * corners + 1, 1))
        heights += rubble * _blocks(world, corners, level / spacing)
        if bumps:
            heights += _bumps_between(bumps, world, corners, spacing, level)
    else:
        heights = bumps * _bumps(world, corners, level / spacing)
    shares = ((heights - lowest) / range_).astype(np.float32)
    model.hfield_data[:] = shares.ravel()
    return Terrain(lowest + range_ * shares.astype(np.float64), spacing, (-half, -half))


def _bumps(world: Mapping[str, float], corners: int, level: float) -> Floats:
    """Return random heights of corners, 0 to 1; `level` in distances between corners."""
    heights = _draw_outward(np.random.default_rng([world_seed(world), 0]), corners)
    heights[_rings(corners) - 1 <= level] = 0.0
    return heights


def _bumps_between(
    height: float, world: Mapping[str, float], corners: int, spacing: float, level: float
) -> Floats:
    """Return the bumps of a coarse lattice at the corners of a fine lattice, m."""
    wide = round(BUMP / EDGE) * spacing
    reach = math.ceil(corners * spacing / wide)
    bumps = Terrain(height * _bumps(world, reach, level / wide), wide, (-reach * wide,) * 2)
    places = spacing * np.arange(-corners, corners + 1)
    return bumps.height(np.stack(np.meshgrid(places, places), axis=-1))


def _terraces(world: Mapping[str, float], corners: int, level: float) -> Floats:
    """Return the heights of the columns of corners in steps; `level` in distances between them."""
    first = max(math.ceil(level), TERRACE // 2)
    index = np.maximum(np.arange(1, corners + 1) - first + TERRACE - 1, 0) // TERRACE
    upward = condition_rng(world, "steps").random((int(index[-1]), 2)) < 0.5
    heights = []
    for side in upward.T.tolist():
        terraces = [0]
        for up in side:
            here = terraces[-1]
            terraces.append(here + (1 if here == -LEVELS or (up and here < LEVELS) else -1))
        heights.append(np.array(terraces, np.float64)[index])
    behind, ahead = heights
    return np.concatenate([behind[::-1], [0.0], ahead])


def _blocks(world: Mapping[str, float], corners: int, level: float) -> Floats:
    """Return random heights of blocks at all corners, 0 to 1; `level` in distances between them."""
    reach = (corners + BLOCK // 2) // BLOCK
    heights = _draw_outward(condition_rng(world, "rubble"), reach)
    # The edge of a block rises from the corner before its first one.
    heights[_rings(reach) * BLOCK - BLOCK // 2 - 1 < level] = 0.0
    block = (np.arange(-corners, corners + 1) + BLOCK // 2) // BLOCK + reach
    return heights[np.ix_(block, block)]


def _draw_outward(rng: np.random.Generator, reach: int) -> Floats:
    """Draw numbers from 0 to 1 for places around a middle, ring by ring.

    A larger reach gives the same numbers near the middle, (2 · reach + 1, 2 · reach + 1).
    """
    rings = _rings(reach)
    drawn = np.empty(rings.size)
    drawn[np.argsort(rings.ravel(), kind="stable")] = rng.random(rings.size)
    return drawn.reshape(rings.shape)


def _rings(reach: int) -> NDArray[np.intp]:
    """Return the number of the square ring around the middle, by row and column."""
    away = np.abs(np.arange(-reach, reach + 1))
    return np.maximum(away[:, None], away)
