"""Write a repaired tree of bodies as the robot's text."""

import math
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from gaitsim_robot.importing.tree import Body, Floats, Joint, Place, Robot, Shape


def write(robot: Robot) -> str:
    """Return the robot's text; add the renamed joints to the robot's repairs."""
    return _Writer(robot).text()


class _Writer:
    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._meshes = Element("asset")
        self._used: dict[str, set[str]] = {"body": {"world"}}  # reserved by MuJoCo

    def text(self) -> str:
        robot = self._robot
        root = Element("mujoco", model=_clean(robot.name) or "robot")
        SubElement(root, "compiler", angle="radian")
        world = Element("worldbody")
        # Writing the bodies makes their names unique; constraints then refer to the new names.
        names: dict[str, str] = {}
        joints: dict[str, str] = {}
        self._body(world, robot.root, names, joints)
        if len(self._meshes):
            root.append(self._meshes)
        root.append(world)
        self._excludes(root, names)
        self._equalities(root, joints)
        self._stand(root)
        indent(root, " ")
        return tostring(root, "unicode") + "\n"

    def _name(self, kind: str, wanted: str) -> str:
        used = self._used.setdefault(kind, set())
        base = _clean(wanted) or kind
        name, count = base, 1
        while name in used:
            count += 1
            name = f"{base} {count}"
        used.add(name)
        return name

    def _body(
        self, parent: Element, body: Body, names: dict[str, str], joints: dict[str, str]
    ) -> None:
        name = names[body.name] = self._name("body", body.name)
        element = SubElement(parent, "body", {"name": name} | _place(body.place))
        if body is self._robot.root:
            SubElement(element, "freejoint", name=self._name("joint", name))
        inertial = {"pos": _numbers(body.centre), "mass": _number(body.mass)}
        SubElement(element, "inertial", inertial | _inertia(body.inertia))
        for joint in body.joints:
            joints[joint.name] = self._name("joint", joint.name)
            if joints[joint.name] != joint.name:
                self._robot.repairs.append(
                    f"joint {joint.name[:100]!r} renamed to {joints[joint.name]!r}: names must be "
                    "unique and printable, and must not look like a formula"
                )
            SubElement(element, "joint", {"name": joints[joint.name]} | _joint(joint))
        for shape in body.shapes:
            self._shape(element, shape)
        for site, place in body.sites.items():
            SubElement(element, "site", {"name": site} | _place(place))
        for child in body.children:
            self._body(element, child, names, joints)

    def _shape(self, parent: Element, shape: Shape) -> None:
        attributes = {"type": shape.kind}
        if shape.vertices is None:
            attributes |= {"size": _numbers(shape.size)} | _place(shape.place)
        else:
            name = attributes["mesh"] = f"mesh {len(self._meshes) + 1}"
            vertices = shape.place.point(shape.vertices)
            digits = 4 - math.floor(math.log10(float(np.ptp(vertices, axis=0).max())))
            words = " ".join(_short(value, digits) for value in vertices.ravel())
            SubElement(self._meshes, "mesh", name=name, vertex=words)
        if (shape.contype, shape.conaffinity) != (1, 1):
            attributes |= {"contype": str(shape.contype), "conaffinity": str(shape.conaffinity)}
        SubElement(parent, "geom", attributes)

    def _excludes(self, root: Element, names: dict[str, str]) -> None:
        pairs = sorted({(names[first], names[second]) for first, second in self._robot.excludes})
        if pairs:
            contact = SubElement(root, "contact")
            for first, second in pairs:
                SubElement(contact, "exclude", body1=first, body2=second)

    def _equalities(self, root: Element, joints: dict[str, str]) -> None:
        robot = self._robot
        if not (robot.couplings or robot.closures):
            return
        equality = SubElement(root, "equality")
        for coupling in robot.couplings:
            values = (*coupling.coefficients, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
            SubElement(
                equality,
                "joint",
                joint1=joints[coupling.follower],
                joint2=joints[coupling.leader],
                polycoef=_numbers(values),
            )
        for closure in robot.closures:
            SubElement(equality, closure.kind, site1=closure.first, site2=closure.second)

    def _stand(self, root: Element) -> None:
        robot = self._robot
        if robot.stand is None:
            return
        place, angles = robot.stand
        qpos = [
            _numbers(place.position),
            _numbers(_quaternion(place.rotation), 7),
            *(_number(angles.get(joint.name, joint.reference)) for joint in robot.joints),
        ]
        SubElement(SubElement(root, "keyframe"), "key", name="stand", qpos=" ".join(qpos))


def _joint(joint: Joint) -> dict[str, str]:
    found = {"axis": _numbers(joint.axis)}
    if np.abs(joint.position).max() > 1e-9:
        found["pos"] = _numbers(joint.position)
    if joint.range is not None:
        found["range"] = _numbers(joint.range)
    if joint.torque > 0:
        found["actuatorfrcrange"] = _numbers((-joint.torque, joint.torque))
    for key, value in (
        ("user", joint.speed),
        ("damping", joint.damping),
        ("armature", joint.armature),
        ("frictionloss", joint.friction),
        ("stiffness", joint.stiffness),
        ("ref", joint.reference),
        ("springref", joint.spring_reference if joint.stiffness else 0.0),
    ):
        if value:
            found[key] = _number(value)
    return found


def _inertia(inertia: Floats) -> dict[str, str]:
    diagonal = np.diag(inertia)
    if np.abs(inertia - np.diag(diagonal)).max() < 1e-5 * diagonal.max():
        return {"diaginertia": _numbers(diagonal)}
    values, axes = np.linalg.eigh(inertia)
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return {"quat": _numbers(_quaternion(axes)), "diaginertia": _numbers(values)}


def _place(place: Place) -> dict[str, str]:
    found = {}
    if np.abs(place.position).max() > 1e-9:
        found["pos"] = _numbers(place.position)
    quaternion = _quaternion(place.rotation)
    if np.abs(quaternion[1:]).max() > 1e-7:
        found["quat"] = _numbers(quaternion, 7)
    return found


def _quaternion(rotation: Floats) -> Floats:
    from scipy.spatial.transform import Rotation

    values = np.roll(Rotation.from_matrix(rotation).as_quat(), 1)
    return values if values[0] >= 0 else -values


def _numbers(values: object, digits: int = 6) -> str:
    found = np.asarray(values, float)
    found = np.where(np.abs(found) < 1e-9 * np.abs(found).max(), 0.0, found)  # rounding errors
    return " ".join(_number(value, digits) for value in found)


def _number(value: float, digits: int = 6) -> str:
    return f"{value:.{digits}g}"


def _short(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return (text.rstrip("0").rstrip(".") if "." in text else text) or "0"


def _clean(name: str) -> str:
    """Return a printable name that spreadsheets do not take for a formula (=, +, -, @)."""
    return "".join(one for one in name if one.isprintable()).strip().lstrip("=+-@ ")[:100]
