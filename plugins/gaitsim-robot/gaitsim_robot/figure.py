"""The drawing of a robot: solids, segments and feet, each in the frame of its body."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitsim.plugin import Shape, Solid, conjugate, rotated
from gaitsim.plugin.toolkit import Damage
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.damaged import lost_bodies
from gaitsim_robot.shapes import CORNERS, mesh_vertices

TRUNK = 1  # number of the trunk's body
SMALLEST = 0.004  # × length of the robot; smaller geoms, such as those of sensors, are omitted
CHEST = 0.5  # × length of the trunk; longer parts that carry several others are drawn as boxes
SLENDER = 0.06  # radius of a limb without geoms as a share of its length
NEAR = 0.01  # × length of the robot; joints closer to each other are drawn as one point
EDGES = [(i, j) for i in range(8) for j in range(i) if (CORNERS[i] != CORNERS[j]).sum() == 1]


@dataclass(frozen=True, eq=False)
class Figure:
    """Segments, solids and feet of a robot. Bodies are numbers in MuJoCo's model.

    Attributes:
        names: names of the segments.
        bodies: bodies of the segments.
        segments: both ends of each segment in the frame of its body, (segments, 2, 3) m.
        solids: the solids.
        owners: bodies of the solids.
        offsets: position, m, and quaternion of each solid in the frame of its body, (solids, 7).
        feet: bodies of the feet, in the order of the legs.
        soles: contact point of each foot in the frame of its body, (feet, 3) m.
        damaged: names of lost legs, and of the segments and solids that damaged joints move.
    """

    names: tuple[str, ...]
    bodies: tuple[int, ...]
    segments: Floats
    solids: tuple[Solid, ...]
    owners: tuple[int, ...]
    offsets: Floats
    feet: tuple[int, ...]
    soles: Floats
    damaged: tuple[str, ...]


def figure(model: Any, anatomy: Anatomy, damage: Sequence[Damage] = ()) -> Figure:
    """Return the drawing of a robot; lost legs are omitted.

    Args:
        model: MuJoCo's compiled model.
        anatomy: anatomy of the robot.
        damage: damage of the robot.
    """
    lost = lost_bodies(model, anatomy, damage)
    names, bodies, points = _segments(model, anatomy, lost)
    solids, owners, offsets = _solids(model, anatomy)
    for name, body, (one, other) in zip(names, bodies, points, strict=True):
        if body != TRUNK and body not in owners:  # a limb without geoms
            solids.append(_rod(name, float(np.linalg.norm(other - one))))
            owners.append(body)
            offsets.append(np.array([*(one + other) / 2, *_turn_to(other - one)]))
    named = (*names, *(one.name for one in solids))
    return Figure(
        names,
        tuple(bodies),
        points,
        tuple(solids),
        tuple(owners),
        np.array(offsets).reshape(-1, 7),
        tuple(int(model.body(leg.foot).id) for leg in anatomy.legs),
        np.array([leg.point for leg in anatomy.legs]),
        _damaged_parts(model, damage, named, [*bodies, *owners]),
    )


def _damaged_parts(
    model: Any, damage: Sequence[Damage], names: Sequence[str], bodies: Sequence[int]
) -> tuple[str, ...]:
    """Return the names of lost legs, and of all parts that damaged joints move."""
    legs = [one.part for one in damage if one.kind == "lost"]
    moved = {int(model.joint(one.part).bodyid[0]) for one in damage if one.kind != "lost"}
    for body in range(1, model.nbody):  # parents before children
        if not model.body_jntnum[body] and int(model.body_parentid[body]) in moved:
            moved.add(body)
    return (*legs, *(name for name, body in zip(names, bodies, strict=True) if body in moved))


def body_poses(model: Any, configuration: Floats) -> tuple[Floats, Floats]:
    """Return positions, (frames, bodies, 3) m, and quaternions, (frames, bodies, 4), of bodies."""
    import mujoco

    data = mujoco.MjData(model)
    places = np.empty((len(configuration), model.nbody, 3))
    turns = np.empty((len(configuration), model.nbody, 4))
    for frame, positions in enumerate(configuration):
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        places[frame], turns[frame] = data.xpos, data.xquat
    return places, turns


def _solids(model: Any, anatomy: Anatomy) -> tuple[list[Solid], list[int], list[Floats]]:
    """Return a solid for each geom, its body, and its pose in the body's frame, (7,)."""
    import mujoco

    kinds = mujoco.mjtGeom
    shapes: dict[Any, tuple[Shape, int]] = {
        kinds.mjGEOM_BOX: ("box", 3),
        kinds.mjGEOM_SPHERE: ("sphere", 1),
        kinds.mjGEOM_CAPSULE: ("capsule", 2),
        kinds.mjGEOM_CYLINDER: ("cylinder", 2),
        kinds.mjGEOM_ELLIPSOID: ("ellipsoid", 3),
        kinds.mjGEOM_MESH: ("mesh", 0),
    }
    parts = _leg_names(model, anatomy)
    parts |= dict.fromkeys(_spine(model, parts), "spine")
    solids: list[Solid] = []
    owners: list[int] = []
    offsets: list[Floats] = []
    for geom in range(model.ngeom):
        body, kind = int(model.geom_bodyid[geom]), kinds(model.geom_type[geom])
        small = model.geom_rbound[geom] < SMALLEST * anatomy.length
        if not body or kind not in shapes or small:
            continue
        shape, count = shapes[kind]
        name = _with_part_name(parts.get(body, ""), model.body(body).name)
        size = tuple(model.geom_size[geom, :count].tolist())
        solids.append(Solid(name, shape, size, None if count else mesh_vertices(model, geom)))
        owners.append(body)
        offsets.append(np.concatenate([model.geom_pos[geom], model.geom_quat[geom]]))
    return solids, owners, offsets


def _rod(name: str, length: float) -> Solid:
    """Return a thin capsule of a given length, m."""
    return Solid(name, "capsule", (SLENDER * length, (0.5 - SLENDER) * length))


def _turn_to(along: Floats) -> Floats:
    """Return the quaternion that turns z along a vector, (4,)."""
    x, y, z = along / np.linalg.norm(along)
    if z < 1e-9 - 1:
        return np.array([0.0, 1.0, 0.0, 0.0])
    turn = np.array([1 + z, -y, x, 0.0])
    return np.asarray(turn / np.linalg.norm(turn))


def _leg_names(model: Any, anatomy: Anatomy) -> dict[int, str]:
    """Return the leg's name for each body that belongs to a leg."""
    found = {model.joint(name).bodyid[0]: leg.name for leg in anatomy.legs for name in leg.joints}
    for body in range(1, model.nbody):  # parents before children
        parent = int(model.body_parentid[body])
        if body not in found and parent in found:
            found[body] = found[parent]
    return {int(body): name for body, name in found.items()}


def _spine(model: Any, legs: Mapping[int, str]) -> set[int]:
    """Return the bodies between the trunk and the legs; names such as 'L_1' are not their sides."""
    found = {int(model.body_parentid[body]) for body in legs} - legs.keys()
    for body in range(model.nbody - 1, TRUNK, -1):  # children before parents
        if body in found:
            found.add(int(model.body_parentid[body]))
    return {body for body in found if body > TRUNK}


def _with_part_name(part: str, name: str) -> str:
    """Return a name that starts with the name of its leg or 'spine', if any."""
    return name if not part or name.startswith(f"{part} ") else f"{part} {name}"


def _segments(
    model: Any, anatomy: Anatomy, lost: set[int]
) -> tuple[tuple[str, ...], list[int], Floats]:
    """Return the edges of the trunk's box, and the segments from joint to joint and to the feet.

    Segments of lost bodies are omitted.

    Returns:
        The segments' names, their bodies, and their ends in the frames of these bodies,
        (segments, 2, 3) m.
    """
    legs = _leg_names(model, anatomy)
    parts = dict.fromkeys(_spine(model, legs), "spine") | legs
    home, turn = (of[0] for of in body_poses(model, model.qpos0[None]))
    # For each body, the body to which it is rigidly fixed: itself if it has a joint.
    rigid = list(range(model.nbody))
    for body in range(TRUNK + 1, model.nbody):
        if not model.body_jntnum[body]:
            rigid[body] = rigid[model.body_parentid[body]]

    def in_frame(point: Floats, body: int, frame: int) -> Floats:
        """Return a point of a body in the frame of the body to which it is rigidly fixed."""
        away = home[body] + rotated(turn[body], point) - home[frame]
        return rotated(conjugate(turn[frame]), away)

    hinged = [body for body in range(TRUNK + 1, model.nbody) if model.body_jntnum[body]]
    anchors = {body: model.jnt_pos[model.body_jntadr[body]] for body in hinged}
    # The body of each segment, the body whose leg its name starts with, and its far end.
    ends = []
    for body, anchor in anchors.items():
        parent = rigid[model.body_parentid[body]]
        ends.append((parent, body, in_frame(anchor, body, parent)))
    for leg in anatomy.legs:
        foot = model.body(leg.foot).id
        ends.append((rigid[foot], foot, in_frame(np.array(leg.point), foot, rigid[foot])))
    children = Counter(body for body, _, _ in ends)
    corners = {body: _corners(model, body) for body in (TRUNK, *hinged)}
    for body in hinged:
        if body not in children:
            ends.append((body, body, _tip(anchors[body], model.body_ipos[body], corners[body])))
    # Large parts that carry several others, such as a chest, are boxes like the trunk.
    large = CHEST * _reach(corners[TRUNK])
    boxes = {TRUNK: corners[TRUNK]} | {
        body: corners[body]
        for body in hinged
        if children[body] > 1 and body not in legs and _reach(corners[body]) > large
    }
    found = []
    for body, points in boxes.items():
        name = _with_part_name(parts.get(body, ""), model.body(body).name)
        found += [(name, body, one, other) for one, other in _edges(points)]
    for body, beyond, end in ends:
        start = np.clip(end, *_box(boxes[body])) if body in boxes else anchors[body]
        if body not in lost and np.linalg.norm(end - start) > NEAR * anatomy.length:
            name = "hip" if body == TRUNK and beyond in legs else model.body(body).name
            found.append((_with_part_name(parts.get(beyond, ""), name), body, start, end))
    names, bodies, starts, far = zip(*found, strict=True)
    return names, list(bodies), np.stack([np.array(starts), np.array(far)], axis=1)


def _tip(anchor: Floats, middle: Floats, corners: Floats) -> Floats:
    """Return the far end of an arm or head: the extent of its shape in the direction `middle`."""
    along = middle - anchor
    length = float(np.linalg.norm(along))
    if not len(corners) or length < 1e-9:
        return anchor + 2 * along
    return np.asarray(anchor + along * max(((corners - anchor) @ along).max() / length**2, 0.0))


def _corners(model: Any, body: int) -> Floats:
    """Return the corners of the boxes around the geoms of a body, in its frame, (corners, 3) m."""
    own = np.flatnonzero(model.geom_bodyid == body)
    middle, half = model.geom_aabb[own, None, :3], model.geom_aabb[own, None, 3:]
    corners = rotated(model.geom_quat[own, None], middle + CORNERS * half)
    return np.asarray((corners + model.geom_pos[own, None]).reshape(-1, 3))


def _box(corners: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and the highest corner of the box around points."""
    return (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.zeros(3),) * 2


def _reach(corners: Floats) -> float:
    """Return the longest side of the box around points."""
    return float(np.ptp(np.stack(_box(corners)), axis=0).max())


def _edges(corners: Floats) -> list[tuple[Floats, Floats]]:
    """Return both ends of the twelve edges of the box around points."""
    low, high = _box(corners)
    box = np.where(CORNERS < 0, low, high)
    return [(box[i], box[j]) for i, j in EDGES]
