"""Conversion of a robot compiled by MuJoCo into links of Bullet.

Each joint becomes a link of Bullet, as a body of MuJoCo may have several joints. The frame of a
link has the axes of its body, and its origin is at the joint. Bullet's joints are at 0 in the pose
in which they are created, the reference pose of the file.

Bullet does not support armature, the inertia of a motor's rotor as seen through its gears. The
armature of a hobby servo is about a hundred times the inertia of a shank, and determines how fast a
joint follows. Each joint with armature therefore gets a rotor: a link on the same axis, geared to
the joint, whose inertia is the armature divided by the square of the gear ratio.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gaitsim.plugin import product, rotated
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.damaged import LOCKED
from gaitsim_robot.errors import RobotError
from gaitsim_robot.simulation import Simulation

TRUNK = 1  # number of the trunk's body
RATIO = 2000.0  # gear ratio, high enough that the rotor's own inertia is negligible
LIGHT = 1e-6  # share of the robot's mass, for links without a body; lighter limbs are lost legs
ROTOR = 1e-9  # kg, mass of a rotor
NEAR = 1e-3  # m, radius of gyration of a link without a body

ONE = np.array([1.0, 0.0, 0.0, 0.0])
"""The identity quaternion."""


@dataclass(frozen=True, eq=False)
class Inertia:
    """The mass and inertia of a link.

    Attributes:
        mass: mass, kg.
        moments: moments of inertia about the principal axes, (3,) kg m².
        centre: centre of mass in the link's frame, (3,) m.
        turn: rotation of the principal axes in that frame, (w, x, y, z).
    """

    mass: float
    moments: Floats
    centre: Floats
    turn: Floats


@dataclass(frozen=True, eq=False)
class BulletLink:
    """A link of Bullet.

    Attributes:
        parent: index of the parent link, -1 for the trunk.
        kind: kind of its joint.
        place: position of its frame in the parent's frame, (3,) m.
        turn: rotation of its frame in the parent's frame, (w, x, y, z).
        axis: axis of its joint in its frame, (3,).
        inertia: mass and inertia.
        joint: number of MuJoCo's joint; -1 for fixed links and rotors.
        body: number of MuJoCo's body; -1 for a rotor, and between two joints of a body.
        origin: origin of the body's frame in the link's frame, (3,) m.
        geared: for a rotor, index of the link to whose joint it is geared; -1 for other links.
    """

    parent: int
    kind: Literal["fixed", "hinge", "slide"]
    place: Floats
    turn: Floats
    axis: Floats
    inertia: Inertia
    joint: int
    body: int
    origin: Floats
    geared: int = -1


def create_links(simulation: Simulation) -> tuple[BulletLink, ...]:
    """Return all links except the trunk, in Bullet's order: depth first."""
    model = simulation.model
    _check(model)
    total = float(model.body_subtreemass[TRUNK])
    links: list[BulletLink] = []
    carrier, origins = {TRUNK: -1}, {TRUNK: np.zeros(3)}
    for body in range(TRUNK + 1, model.nbody):
        parent = int(model.body_parentid[body])
        if parent not in carrier or model.body_subtreemass[body] < LIGHT * total:
            continue  # the body belongs to a lost leg
        place, turn = model.body_pos[body] + origins[parent], model.body_quat[body]
        link, origin = carrier[parent], np.zeros(3)
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for joint in range(first, first + count) or (-1,):
            if joint >= 0:
                place = place + rotated(turn, model.jnt_pos[joint] + origin)
                origin = -model.jnt_pos[joint]
                turn = product(turn, _locked_rotation(simulation, joint))
            owner = body if joint in (-1, first + count - 1) else -1
            links += _joint_links(simulation, joint, link, place, turn, owner, origin, len(links))
            link, place, turn = len(links) - 1, np.zeros(3), ONE
        carrier[body], origins[body] = link, origin
    return tuple(links)


def is_locked(simulation: Simulation, joint: int) -> bool:
    """Return whether damage locks a joint; a locked joint has a large armature."""
    anatomy, armature = simulation.anatomy, _armature(simulation.model, joint)
    return bool(armature > 0.1 * LOCKED * anatomy.mass * anatomy.length**2)


def _locked_rotation(simulation: Simulation, joint: int) -> Floats:
    """Return a locked joint's rotation from the reference pose; the identity for other joints."""
    model = simulation.model
    if not is_locked(simulation, joint):
        return ONE
    address = model.jnt_qposadr[joint]
    half = (model.qpos_spring[address] - model.qpos0[address]) / 2
    return np.array([np.cos(half), *(np.sin(half) * model.jnt_axis[joint])])


def _joint_links(
    simulation: Simulation,
    joint: int,
    parent: int,
    place: Floats,
    turn: Floats,
    body: int,
    origin: Floats,
    index: int,
) -> list[BulletLink]:
    """Return the link of a joint, after its rotor, or the link of a body without a joint."""
    import mujoco

    model = simulation.model
    mass = LIGHT * float(model.body_subtreemass[TRUNK])
    inertia = Inertia(mass, np.full(3, mass * NEAR**2), np.zeros(3), ONE)
    if body >= 0:
        inertia = Inertia(
            max(float(model.body_mass[body]), mass),
            np.maximum(model.body_inertia[body], inertia.moments),
            model.body_ipos[body] + origin,
            model.body_iquat[body],
        )
    if joint < 0 or is_locked(simulation, joint):
        axis = np.array([0.0, 0.0, 1.0])
        return [BulletLink(parent, "fixed", place, turn, axis, inertia, -1, body, origin)]
    slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    kind: Literal["hinge", "slide"] = "slide" if slides else "hinge"
    axis, armature = model.jnt_axis[joint], _armature(model, joint)
    moving = BulletLink(parent, kind, place, turn, axis, inertia, joint, body, origin)
    if not armature:
        return [moving]
    rotor = Inertia(ROTOR, np.full(3, armature / RATIO**2), np.zeros(3), ONE)
    return [
        BulletLink(parent, "hinge", place, turn, axis, rotor, -1, -1, origin, index + 1),
        moving,
    ]


def _armature(model: Any, joint: int) -> float:
    return float(model.dof_armature[model.jnt_dofadr[joint]])


def _check(model: Any) -> None:
    """Raise an error for parts that this engine does not simulate."""
    import mujoco

    slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    refused = {
        "slides with motors": slides[model.actuator_trnid[:, 0]].any(),
        "ball joints": (model.jnt_type == mujoco.mjtJoint.mjJNT_BALL).any(),
        "mimic joints and closed linkages": bool(model.neq) and model.eq_active0.any(),
        "tendons": bool(model.ntendon),
        "uneven ground": (model.geom_type == mujoco.mjtGeom.mjGEOM_HFIELD).any(),
    }
    found = [name for name, present in refused.items() if present]
    if found:
        raise RobotError(
            f"the engine 'bullet' does not simulate {' and '.join(found)}",
            key="engine",
            allowed="'bullet' only for robots with hinge and slide joints on flat ground",
            remedy='set organism.engine = "mujoco"',
        )
