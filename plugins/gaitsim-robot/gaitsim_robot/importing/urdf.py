"""Read a URDF (http://wiki.ros.org/urdf/XML) into a tree of bodies."""

from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from gaitsim_robot.errors import RobotError, format_names
from gaitsim_robot.importing.files import RobotFiles
from gaitsim_robot.importing.meshes import MeshFiles, turn_up
from gaitsim_robot.importing.tree import (
    SWAPPED,
    Body,
    Coupling,
    Floats,
    Place,
    RobotTree,
    Shape,
    TreeJoint,
    report,
)
from gaitsim_robot.markup import EXPAND, LARGEST_INERTIA, number, numbers

# MuJoCo's kind for each movable kind of joint in URDF. Repairs fix balls, hence also planar joints.
_KINDS = {
    "revolute": "hinge", "continuous": "hinge", "prismatic": "slide", "floating": "free",
    "planar": "ball", "spherical": "ball",
}  # fmt: skip


def read_urdf(root: Element, files: RobotFiles, where: str) -> RobotTree:
    """Return the robot of a URDF document."""
    unused = _check_expanded(root, where)
    files.names = {mesh.get("filename", "") for mesh in root.iter("mesh")}
    robot = _UrdfReader(root, files, where).robot()
    report(robot.repairs, "unused properties of xacro ignored", unused)
    return robot


def _check_expanded(root: Element, where: str) -> list[str]:
    """Check that a document is URDF rather than a xacro file, which contains macros.

    Returns:
        The names of properties that are left over from an expanded xacro file, now removed.
    """
    for element in root.iter():
        macro = element.tag.startswith("xacro:") and element.tag != _PROPERTY
        formula = next((value for value in element.attrib.values() if "${" in value), "")
        if macro or formula:
            found = f"a formula {formula[:60]!r}" if formula else f"<{element.tag[:60]}>"
            raise RobotError(
                f"the file is a xacro file, not URDF: it contains {found}",
                where=where,
                remedy=EXPAND,
            )
    unused = [one.get("name", "") for one in root.iter(_PROPERTY)]
    for parent in list(root.iter()) if unused else ():
        parent[:] = [child for child in parent if child.tag != _PROPERTY]
    return unused


_PROPERTY = "xacro:property"


class _UrdfReader:
    def __init__(self, root: Element, files: RobotFiles, where: str) -> None:
        self._root = root
        self._files = files
        self._where = where
        self._repairs: list[str] = []
        self._swapped: list[str] = []
        self._children: set[str] = set()
        self._couplings: list[Coupling] = []
        self._y_up: list[tuple[Body, Shape]] = []
        meshes = _get(root, "mujoco/compiler", "meshdir")
        self._meshes = MeshFiles(files, ("", meshes) if meshes else ("",))

    def robot(self) -> RobotTree:
        links = {self._name(link): link for link in self._root.iterfind("link")}
        if not links:
            raise RobotError(
                "the URDF has no links",
                where=self._where,
                allowed="at least two <link>",
            )
        bodies = {name: self._body(name, link) for name, link in links.items()}
        if turn_up(self._y_up):
            self._repairs.append("COLLADA meshes rotated from y up to z up")
        for element in self._root.iterfind("joint"):
            self._attach(element, bodies)
        report(self._repairs, SWAPPED, self._swapped)
        root = self._topmost(bodies)
        stated = self._motors(root)
        self._repairs += self._files.describe_missing()
        name = self._root.get("name", "")
        return RobotTree(name, root, self._couplings, repairs=self._repairs, motors_stated=stated)

    def _motors(self, root: Body) -> bool:
        """Leave motors where the file states them, or else in all but mimic joints; read springs.

        Motors are stated by `<transmission>` or `<ros2_control>`, springs by Gazebo's extension.

        Returns:
            Whether the file states motors.
        """
        stated = {one.get("name") for one in self._root.iterfind("transmission/joint")} | {
            one.get("name")
            for one in self._root.iterfind("ros2_control/joint")
            if one.find("command_interface") is not None
        }
        followers = {coupling.follower for coupling in self._couplings}
        springs = {
            one.get("reference", ""): one
            for one in self._root.iterfind("gazebo")
            if one.find("springStiffness") is not None
        }
        joints = [joint for body in root.walk() for joint in body.joints]
        stated &= {joint.name for joint in joints}
        for joint in joints:
            joint.driven = joint.name in stated if stated else joint.name not in followers
            if (spring := springs.get(joint.name)) is not None:
                where = f"{self._where}, <gazebo> of joint {joint.name!r}"
                joint.stiffness, joint.spring_reference = (
                    number(spring.findtext(tag), 0.0, where)
                    for tag in ("springStiffness", "springReference")
                )
        return bool(stated)

    def _topmost(self, bodies: dict[str, Body]) -> Body:
        tops = [bodies[name] for name in bodies if name not in self._children]
        if sum(1 for top in tops for _ in top.walk()) < len(bodies):
            raise RobotError(
                "the links of the URDF form a loop",
                where=self._where,
                allowed="a tree of links with one root",
            )
        root = max(tops, key=lambda top: sum(1 for _ in top.walk()))
        others = [top.name for top in tops if top is not root]
        report(self._repairs, "dropped links that are not part of the robot", others)
        return self._floating_root(root)

    def _floating_root(self, root: Body) -> Body:
        """Return the robot's floating body if the root is a world, or the root itself."""
        for body in list(root.walk()):
            if not any(joint.kind == "free" for joint in body.joints):
                continue
            joint = body.joints[0].name
            if _moving(body) == _moving(root):
                rest = {one.name for one in root.walk()} - {one.name for one in body.walk()}
                report(self._repairs, "dropped links outside the floating robot", sorted(rest))
                body.joints, body.place = [], Place()
                return body
            self._repairs.append(f"floating joint {joint!r} within the robot fixed")
            body.joints = []
        return root

    def _name(self, element: Element) -> str:
        name = element.get("name")
        if not name:
            raise RobotError(f"a <{element.tag}> has no name", where=self._where)
        return name

    def _place(self, element: Element | None, where: str) -> Place:
        if element is None:
            return Place()
        turn = Rotation.from_euler("xyz", self._vector(element, "rpy", where))  # about fixed axes
        return Place(self._vector(element, "xyz", where), turn.as_matrix())

    def _vector(self, element: Element, key: str, where: str) -> Floats:
        words = element.get(key, "").split()
        if len(words) > 3:
            self._repairs.append(f"ignored numbers after the third: {key}={' '.join(words)[:80]!r}")
        return numbers(" ".join(words[:3]), 3, "0 0 0", where)

    def _body(self, name: str, link: Element) -> Body:
        where = f"{self._where}, link {name!r}"
        body = Body(name)
        inertial = link.find("inertial")
        if inertial is not None:
            place = self._place(inertial.find("origin"), where)
            body.mass = number(_get(inertial, "mass", "value"), 0.0, where)
            if body.mass < 0:
                raise RobotError(
                    f"the mass is negative: {body.mass:g} kg", where=where, allowed="0 kg or more"
                )
            body.centre = place.position
            tensor = inertial.find("inertia")
            if tensor is not None:
                xx, xy, xz, yy, yz, zz = (
                    number(tensor.get(key), 0.0, where, LARGEST_INERTIA)
                    for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
                )
                local = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                body.inertia = place.rotation @ local @ place.rotation.T
        self._shapes(body, link, "collision", where)
        if not body.shapes:
            self._shapes(body, link, "visual", where)
        return body

    def _shapes(self, body: Body, link: Element, tag: str, where: str) -> None:
        for element in link.iterfind(tag):
            geometry = element.find("geometry")
            if geometry is None or not len(geometry):
                continue
            place = self._place(element.find("origin"), where)
            shape = self._shape(geometry[0], place, where)
            if shape is not None:
                if geometry[0].get("filename") in self._meshes.y_up:
                    self._y_up.append((body, shape))
                shape.collides = tag == "collision"
                body.shapes.append(shape)
            else:
                body.lost |= tag == "collision"
                body.incomplete = True

    def _shape(self, solid: Element, place: Place, where: str) -> Shape | None:
        def length(key: str) -> float:
            value = number(solid.get(key), 0.0, where)
            if value <= 0:
                raise RobotError(f"the {key} of a {solid.tag} must be positive", where=where)
            return value

        match solid.tag:
            case "box":
                size = numbers(solid.get("size"), 3, "", where)
                if not (size > 0).all():
                    self._repairs.append(f"dropped a flat box: {where.rpartition(', ')[2]}")
                    return None
                return Shape("box", place, size / 2)
            case "sphere":
                return Shape("sphere", place, np.array([length("radius")]))
            case "cylinder" | "capsule":
                size = np.array([length("radius"), length("length") / 2])
                return Shape(solid.tag, place, size)
            case "mesh":
                vertices = self._meshes.vertices(solid.get("filename", ""))
                if vertices is None:
                    return None
                scale = numbers(solid.get("scale"), 3, "1 1 1", where)
                return Shape("mesh", place, vertices=vertices * scale)
        self._repairs.append(f"dropped unknown geometry <{solid.tag[:40]}>")
        return None

    def _attach(self, element: Element, bodies: dict[str, Body]) -> None:
        name = self._name(element)
        where = f"{self._where}, joint {name!r}"

        def link(tag: str) -> str:
            found = _get(element, tag, "link") or ""
            if found not in bodies:
                raise RobotError(
                    f"the {tag} link {found!r} does not exist",
                    where=where,
                    allowed=format_names(list(bodies), 20),
                )
            return found

        parent, child = link("parent"), link("child")
        if child in self._children:
            raise RobotError(
                f"link {child!r} has two parents: a URDF cannot describe a closed linkage",
                where=where,
                remedy="remove one of the joints, or write the robot as MJCF with <connect>",
            )
        self._children.add(child)
        body = bodies[child]
        body.place = self._place(element.find("origin"), where)
        bodies[parent].children.append(body)
        kind = element.get("type", "")
        if kind == "fixed":
            return
        if kind not in _KINDS:
            raise RobotError(
                f"unknown type of joint {kind!r}",
                where=where,
                allowed=", ".join([*_KINDS, "fixed"]),
            )
        joint = self._joint(element, name, kind, where)
        if joint is not None:
            body.joints.append(joint)
            mimic = element.find("mimic")
            if mimic is not None:
                offset = number(mimic.get("offset"), 0.0, where)
                factor = number(mimic.get("multiplier"), 1.0, where)
                self._couplings.append(Coupling(name, mimic.get("joint", ""), (offset, factor)))

    def _joint(self, element: Element, name: str, kind: str, where: str) -> TreeJoint | None:
        axis = numbers(_get(element, "axis", "xyz"), 3, "1 0 0", where)
        if not np.linalg.norm(axis) > 1e-6:
            if _KINDS[kind] == "hinge":
                raise RobotError(
                    "the axis is zero", where=where, allowed="a direction such as 0 1 0"
                )
            axis = np.array([1.0, 0.0, 0.0])
        joint = TreeJoint(name, _KINDS[kind], axis / np.linalg.norm(axis))
        low, high, torque, speed = (  # infinite, or huge such as 1e16, for no limit
            number(_get(element, "limit", key), 0.0, where, np.inf)
            for key in ("lower", "upper", "effort", "velocity")
        )
        joint.torque, joint.speed = max(torque, 0.0), max(speed, 0.0)
        if kind in ("revolute", "prismatic") and element.find("limit[@lower][@upper]") is not None:
            if low == high:
                self._repairs.append(f"joint {name!r} fixed, because its range is empty")
                return None
            if low > high:
                self._swapped.append(f"{name} ({low:.4g} to {high:.4g})")
            joint.range = (min(low, high), max(low, high))
        if kind == "continuous":
            joint.range = (-np.inf, np.inf)
        joint.damping, joint.friction = (
            max(number(_get(element, "dynamics", key), 0.0, where), 0.0)
            for key in ("damping", "friction")
        )
        return joint


def _get(element: Element, path: str, key: str) -> str | None:
    """Return the attribute of an element below `element`, or None if one of them is missing."""
    found = element.find(path)
    return None if found is None else found.get(key)


def _moving(body: Body) -> int:
    kinds = ("hinge", "slide")
    return sum(joint.kind in kinds for part in body.walk() for joint in part.joints)
