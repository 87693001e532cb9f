"""Write a robot as URDF (http://wiki.ros.org/urdf/XML), with simple shapes."""

import math
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from gaitsim.plugin import product, rotated
from gaitsim.plugin.toolkit import Servo, arctan2
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.figure import TRUNK
from gaitsim_robot.rollout import tilt_and_yaw
from gaitsim_robot.skeleton import rig

UNKNOWN_EFFORT = 100.0  # N m, as a URDF needs a limit
UNKNOWN_SPEED = 100.0  # rad/s
STRAIGHT = 1 - 1e-12  # sine of a pitch that counts as a right angle
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def urdf(model: Any, anatomy: Anatomy, servos: Mapping[str, Servo], meshes: str = "") -> str:
    """Return a robot as URDF; '' if it has no rig.

    The trunk's frame has x forward, y to the left and z up. Joints outside the legs are fixed in
    the standing pose. Capsules are cylinders with spheres, and ellipsoids are boxes, as are meshes
    without a folder.

    Args:
        model: MuJoCo's compiled model, without damage.
        anatomy: anatomy of the robot.
        servos: servos of its driven joints by the joints' names.
        meshes: folder of the files of `mesh_files`, relative to the URDF; '' for none.
    """
    tree = rig(model, anatomy)
    if tree is None:
        return ""
    robot = Element("robot", name="robot")
    trunk = np.array(tree.links[0].rotation)
    bodies = {model.body(body).name or f"body {body}": body for body in range(TRUNK, model.nbody)}
    for link in tree.links:
        element = SubElement(robot, "link", name=link.name)
        turn = _IDENTITY if link.parent else trunk
        if link.name not in bodies:  # between two joints of a body
            continue
        body = bodies[link.name]
        last = int(model.body_jntadr[body] + model.body_jntnum[body] - 1)
        shift = model.jnt_pos[last] if link.parent and model.body_jntnum[body] else np.zeros(3)
        _add_inertia(element, model, body, shift, turn)
        for geom in np.flatnonzero(model.geom_bodyid == body).tolist():
            place = rotated(turn, model.geom_pos[geom] - shift)
            pose = place, product(turn, model.geom_quat[geom])
            collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
            for tag in ("visual", *(["collision"] if collides else [])):
                for shape, position, direction in _shapes(model, geom, *pose, meshes):
                    part = SubElement(element, tag)
                    _add_origin(part, position, direction)
                    SubElement(part, "geometry").append(shape)
    for link in tree.links[1:]:
        kind = "revolute" if link.joint else "fixed"
        joint = SubElement(robot, "joint", name=link.joint or f"{link.name} fixed", type=kind)
        first = link.parent == tree.links[0].name
        origin, rotation = np.array(link.origin), np.array(link.rotation)
        if first:
            origin, rotation = rotated(trunk, origin), product(trunk, rotation)
        _add_origin(joint, origin, rotation)
        SubElement(joint, "parent", link=link.parent)
        SubElement(joint, "child", link=link.name)
        if link.joint:
            _add_limits(joint, model, link.joint, link.axis, servos[link.joint])
    indent(robot)
    return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"


def _add_inertia(link: Element, model: Any, body: int, shift: Floats, turn: Floats) -> None:
    inertial = SubElement(link, "inertial")
    place = rotated(turn, model.body_ipos[body] - shift)
    _add_origin(inertial, place, product(turn, model.body_iquat[body]))
    SubElement(inertial, "mass", value=_number(model.body_mass[body]))
    xx, yy, zz = (_number(value) for value in model.body_inertia[body])
    SubElement(inertial, "inertia", ixx=xx, ixy="0", ixz="0", iyy=yy, iyz="0", izz=zz)


def _add_limits(
    joint: Element, model: Any, name: str, axis: tuple[float, float, float], servo: Servo
) -> None:
    index = model.joint(name).id
    low, high = model.jnt_range[index]
    SubElement(joint, "axis", xyz=_numbers(np.array(axis)))
    SubElement(
        joint,
        "limit",
        lower=_number(low),
        upper=_number(high),
        effort=_number(_known(servo.stall_torque, UNKNOWN_EFFORT)),
        velocity=_number(_known(servo.no_load_speed, UNKNOWN_SPEED)),
    )
    degree = int(model.jnt_dofadr[index])
    damping, friction = model.dof_damping[degree], model.dof_frictionloss[degree]
    SubElement(joint, "dynamics", damping=_number(damping), friction=_number(friction))


def _shapes(
    model: Any, geom: int, place: Floats, turn: Floats, meshes: str
) -> Iterator[tuple[Element, Floats, Floats]]:
    """Yield the shapes of a geom, with their positions and rotations in the frame of the link."""
    import mujoco

    kinds, size = mujoco.mjtGeom, model.geom_size[geom]
    kind = kinds(model.geom_type[geom])
    if kind == kinds.mjGEOM_SPHERE:
        yield Element("sphere", radius=_number(size[0])), place, turn
    elif kind in (kinds.mjGEOM_CAPSULE, kinds.mjGEOM_CYLINDER):
        radius, length = _number(size[0]), _number(2 * size[1])
        yield Element("cylinder", radius=radius, length=length), place, turn
        ends = (-1, 1) if kind == kinds.mjGEOM_CAPSULE else ()
        for end in ends:
            there = place + rotated(turn, np.array([0.0, 0.0, end * size[1]]))
            yield Element("sphere", radius=radius), there, turn
    elif kind == kinds.mjGEOM_MESH and meshes:
        name = f"{meshes}/{_mesh_name(int(model.geom_dataid[geom]))}"
        yield Element("mesh", filename=name), place, turn
    else:
        middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        yield Element("box", size=_numbers(2 * half)), place + rotated(turn, middle), turn


def mesh_files(model: Any) -> dict[str, bytes]:
    """Return the meshes of a robot by file name, as binary STL in metres."""
    found = {}
    for mesh in range(model.nmesh):
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        corners = model.mesh_vert[first : first + count][model.mesh_face[face : face + faces]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        layout = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
        triangles = np.zeros(faces, np.dtype(layout))
        triangles["normal"], triangles["corners"] = normals, corners
        head = b"gaitsim".ljust(80) + np.uint32(faces).astype("<u4").tobytes()
        found[_mesh_name(mesh)] = head + triangles.tobytes()
    return found


def _mesh_name(mesh: int) -> str:
    return f"mesh-{mesh + 1}.stl"


def _add_origin(element: Element, place: Floats, turn: Floats) -> None:
    SubElement(element, "origin", xyz=_numbers(place), rpy=_numbers(angles(turn)))


def angles(turn: Floats) -> Floats:
    """Return roll, pitch and yaw of a quaternion about fixed axes, (3,) rad."""
    w, x, y, z = turn = turn / np.linalg.norm(turn)
    sine = 2 * (w * y - z * x)
    if abs(sine) > STRAIGHT:  # roll and yaw turn about the same axis
        return np.array([0.0, math.copysign(math.pi / 2, sine), -2 * np.sign(sine) * arctan2(x, w)])
    return tilt_and_yaw(turn)


def _known(value: float, unknown: float) -> float:
    return value if 0 < value < math.inf else unknown


def _numbers(values: Floats) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return f"{value:.9g}"
