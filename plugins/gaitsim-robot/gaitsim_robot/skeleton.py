"""A robot's drawing over time, also on slopes and bumps; the robot as a tree of links."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.plugin import Link, Motion, Rig, Skeleton, product, rotated, turn_about
from gaitsim.plugin.toolkit import Damage, place_on_slope
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.chain import sliding
from gaitsim_robot.damaged import is_stuck, lost_bodies
from gaitsim_robot.figure import TRUNK, body_poses, figure
from gaitsim_robot.simulation import Simulation

VIEW = 10.0  # trunk lengths around the path within which uneven ground is drawn


def skeleton(simulation: Simulation, motion: Motion, individual: int) -> Skeleton:
    """Return the body of one individual over time, on the ground of its world.

    Lost legs are omitted. The origin is the ground below the start.
    """
    model, anatomy, start = simulation.model, simulation.anatomy, simulation.start[1:3]
    bumps = simulation.ground
    configuration = motion["configuration"][individual]
    places, turns = body_poses(model, configuration)
    places[..., :2] -= start
    if bumps is not None:
        x, y = np.array(bumps.corner) - start
        bumps = replace(bumps, corner=(float(x), float(y)))
        bumps = bumps.near(places[:, TRUNK], VIEW * anatomy.length)
    drawing = figure(model, anatomy, simulation.damage)
    bodies, owners, feet = list(drawing.bodies), list(drawing.owners), list(drawing.feet)
    poses = np.concatenate(
        [
            places[:, owners] + rotated(turns[:, owners], drawing.offsets[:, :3]),
            product(turns[:, owners], drawing.offsets[:, 3:]),
        ],
        axis=-1,
    )
    level = Skeleton(
        places[:, bodies, None] + rotated(turns[:, bodies, None], drawing.segments),
        drawing.names,
        motion.frame_rate,
        contacts=places[:, feet] + rotated(turns[:, feet], drawing.soles),
        touching=motion["stance"][individual],
        contact_names=tuple(leg.name for leg in anatomy.legs),
        centre=places[:, TRUNK],
        solids=drawing.solids,
        poses=poses if drawing.solids else None,
        damaged=drawing.damaged,
    )
    return place_on_slope(level, simulation.world, bumps)


def rig(model: Any, anatomy: Anatomy, damage: Sequence[Damage] = ()) -> Rig | None:
    """Return the rig of a robot; None if its linkages do not form a tree, or motors drive slides.

    Joints outside the legs, stuck joints and joints of lost legs stay in the standing pose.

    Args:
        model: MuJoCo's compiled model.
        anatomy: anatomy of the robot with its damage.
        damage: damage of the robot.
    """
    slides = sliding(model)[[model.joint(name).id for name in anatomy.joints]]
    if model.eq_active0.any() or slides.any():  # also mimic joints
        return None
    lost = lost_bodies(model, anatomy, damage)
    stuck = {one.part for one in damage if is_stuck(one)}
    turning = {name for name in anatomy.joints if name not in stuck}
    # A link's origin is on its joint's axis, but a body's need not be: shift points accordingly.
    # The trunk is rotated as in the standing pose, as up and forward vary between files.
    links = [Link(_name(model, TRUNK), rotation=_quaternion(anatomy.stance[3:7]))]
    shifts = {TRUNK: np.zeros(3)}
    names = {TRUNK: links[0].name}
    for body in range(TRUNK + 1, model.nbody):
        parent = int(model.body_parentid[body])
        moving = set() if body in lost else turning
        carrier = names[parent], shifts[parent]
        found, shifts[body] = _links(model, body, *carrier, anatomy.stance, moving)
        links += found
        names[body] = found[-1].name
    drawing = figure(model, anatomy, damage)

    def shifts_of(bodies: Sequence[int]) -> Floats:
        return np.array([shifts[body] for body in bodies]).reshape(-1, 3)

    def links_of(bodies: Sequence[int]) -> tuple[str, ...]:
        return tuple(names[body] for body in bodies)

    poses = drawing.offsets.copy()
    poses[:, :3] -= shifts_of(drawing.owners)
    return Rig(
        tuple(links),
        anatomy.joints,
        drawing.names,
        drawing.segments - shifts_of(drawing.bodies)[:, None],
        links_of(drawing.bodies),
        drawing.soles - shifts_of(drawing.feet),
        links_of(drawing.feet),
        tuple(leg.name for leg in anatomy.legs),
        drawing.solids,
        poses if drawing.solids else None,
        links_of(drawing.owners),
        drawing.damaged,
    )


def _links(
    model: Any, body: int, parent: str, shift: Floats, stance: Floats, turning: set[str]
) -> tuple[list[Link], Floats]:
    """Return a link for each joint of a body, and the last link's origin in the body's frame.

    Args:
        model: MuJoCo's compiled model.
        body: number of the body.
        parent: name of the link that carries the body.
        shift: position of that link's origin in the frame of its body, (3,) m.
        stance: standing pose, (nq,).
        turning: names of the joints that move.
    """
    import mujoco

    kinds = mujoco.mjtJoint
    place, turn = model.body_pos[body] - shift, model.body_quat[body]
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    links: list[Link] = []
    shift = np.zeros(3)
    for index in range(first, first + count):
        joint, at = model.joint(index), int(model.jnt_qposadr[index])
        anchor, axis, kind = model.jnt_pos[index], model.jnt_axis[index], model.jnt_type[index]
        place = place + rotated(turn, anchor - shift)
        shift = anchor
        driven = joint.name in turning
        if kind == kinds.mjJNT_HINGE:
            angle = (0.0 if driven else stance[at]) - model.qpos0[at]
            turn = product(turn, turn_about(axis, angle))
        elif kind == kinds.mjJNT_SLIDE:
            place = place + rotated(turn, axis * (stance[at] - model.qpos0[at]))
        else:
            turn = product(turn, stance[at : at + 4])
        name = _name(model, body) if index == first + count - 1 else f"{joint.name} of the next"
        links.append(
            Link(
                name,
                parent,
                _point(place),
                _quaternion(turn),
                joint.name if driven else "",
                _point(axis) if kind == kinds.mjJNT_HINGE else (0.0, 0.0, 1.0),
            )
        )
        parent, place, turn = name, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    if not links:
        links.append(Link(_name(model, body), parent, _point(place), _quaternion(turn)))
    return links, shift


def _name(model: Any, body: int) -> str:
    return model.body(body).name or f"body {body}"


def _point(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z


def _quaternion(turn: Floats) -> tuple[float, float, float, float]:
    w, x, y, z = (turn / np.linalg.norm(turn)).tolist()
    return w, x, y, z
