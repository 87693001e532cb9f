"""A robot during its import: a tree of bodies that readers build, repairs change and text holds."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gaitsim_robot.errors import format_names

Floats = NDArray[np.float64]
SWAPPED = "swapped limits of joints exchanged"


@dataclass(eq=False)
class Place:
    """A frame within a parent frame.

    Attributes:
        position: position in the parent, (3,) m.
        rotation: matrix whose columns are the frame's axes in the parent, (3, 3).
    """

    position: Floats = field(default_factory=lambda: np.zeros(3))
    rotation: Floats = field(default_factory=lambda: np.eye(3))

    def __matmul__(self, inner: "Place") -> "Place":
        """Convert the place `inner` from this frame to its parent."""
        return Place(self.point(inner.position), self.rotation @ inner.rotation)

    def point(self, points: Floats) -> Floats:
        """Convert points, (…, 3) m, from this frame to its parent."""
        return points @ self.rotation.T + self.position

    def inverse(self) -> "Place":
        """Return the place of the parent in this frame."""
        return Place(-self.position @ self.rotation, self.rotation.T)


@dataclass(eq=False)
class Shape:
    """A solid of a body.

    Attributes:
        kind: sphere, capsule, ellipsoid, cylinder, box or mesh.
        place: place in the body.
        size: MuJoCo's size (half lengths), m.
        vertices: vertices of a mesh in the shape's frame, (n, 3) m.
        collides: whether the shape collides; otherwise it is only visible.
        contype, conaffinity: MuJoCo's contact bits.
    """

    kind: str
    place: Place
    size: Floats = field(default_factory=lambda: np.zeros(0))
    vertices: Floats | None = None
    collides: bool = True
    contype: int = 1
    conaffinity: int = 1


@dataclass(eq=False)
class TreeJoint:
    """A joint between a body and its parent.

    Attributes:
        name: name of the joint.
        kind: hinge, slide, ball or free.
        driven: whether a motor drives the joint; otherwise it is passive.
        axis, position: axis and position in the body, (3,).
        range: smallest and largest angle, rad; None if the file has no limits. For a slide, m for
            rad, and N for N·m, here and below.
        torque: largest torque, N·m; 0 if unknown.
        speed: largest speed, rad/s; 0 if unknown.
        damping, armature, friction, stiffness, reference, spring_reference: MuJoCo's attributes.
        servo_stiffness, servo_damping: torque per position error, N·m/rad, and per speed,
            N·m·s/rad, of its position servo; 0 if unknown.
    """

    name: str
    kind: str
    axis: Floats
    position: Floats = field(default_factory=lambda: np.zeros(3))
    range: tuple[float, float] | None = None
    torque: float = 0.0
    speed: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    reference: float = 0.0
    spring_reference: float = 0.0
    servo_stiffness: float = 0.0
    servo_damping: float = 0.0
    driven: bool = True

    def rescale(self, length: float, mass: float) -> None:
        """Multiply lengths and masses, as `RobotTree.rescale`."""
        self.position = length * self.position
        if self.kind != "slide":
            self.armature *= mass * length**2
            return
        self.armature *= mass
        for name in ("speed", "reference", "spring_reference"):
            setattr(self, name, length * getattr(self, name))
        for name in ("stiffness", "damping", "servo_stiffness", "servo_damping"):
            setattr(self, name, getattr(self, name) / length)
        if self.range is not None:
            self.range = length * self.range[0], length * self.range[1]


@dataclass(eq=False)
class Body:
    """A rigid body, its joints towards the parent, and its children.

    Attributes:
        name: name of the body.
        place: place in the parent.
        mass: mass, kg.
        centre: centre of mass in the body, (3,) m.
        inertia: inertia about the centre of mass, along the body's axes, (3, 3) kg·m².
        shapes: solids of the body.
        joints: joints between the parent and the body.
        sites: frames used by equality constraints, by name.
        children: bodies that this body carries.
        lost: whether colliding geometry is missing, because its mesh cannot be read.
        incomplete: whether any geometry is missing for that reason.
        pulley: whether the body is the pulley of a tendon, which has no shape.
    """

    name: str
    place: Place = field(default_factory=Place)
    mass: float = 0.0
    centre: Floats = field(default_factory=lambda: np.zeros(3))
    inertia: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    shapes: list[Shape] = field(default_factory=list)
    joints: list[TreeJoint] = field(default_factory=list)
    sites: dict[str, Place] = field(default_factory=dict)
    children: list["Body"] = field(default_factory=list)
    lost: bool = False
    incomplete: bool = False
    pulley: bool = False

    def walk(self) -> Iterator["Body"]:
        """Yield this body and all below it, parents first."""
        pending = [self]
        while pending:
            body = pending.pop()
            yield body
            pending += reversed(body.children)

    @property
    def colliding(self) -> list[Shape]:
        """The colliding shapes."""
        return [shape for shape in self.shapes if shape.collides]


@dataclass(frozen=True)
class Coupling:
    """A joint `follower` that follows `leader`: angle = Σ coefficients · leader^power."""

    follower: str
    leader: str
    coefficients: tuple[float, ...]


@dataclass(frozen=True)
class Closure:
    """Two sites that coincide, in a closed linkage (`connect`) or rigidly (`weld`)."""

    kind: str
    first: str
    second: str


@dataclass(frozen=True)
class Tendon:
    """A tendon with the length Σ coefficient · angle, and its spring, damping and limits.

    Attributes:
        name: name of the tendon.
        joints: joints and their coefficients.
        attributes: MuJoCo's attributes and their values.
        taut: whether an equality constraint keeps its length, which couples the joints.
        pulley: name of the joint that turns with the tendon, if a motor pulls it.
        radius: length of tendon per angle of the pulley.
    """

    name: str
    joints: tuple[tuple[str, float], ...]
    attributes: Mapping[str, Sequence[float]]
    taut: bool = False
    pulley: str = ""
    radius: float = 1.0


@dataclass(eq=False)
class RobotTree:
    """A robot.

    Attributes:
        name: name of the robot.
        root: the trunk.
        couplings: mimic joints.
        closures: closed linkages and welds.
        tendons: tendons of joints.
        excludes: pairs of names of bodies that never touch.
        stand: place of the trunk and joint angles, rad, in the keyframe; None without a keyframe.
        repairs: descriptions of everything that was dropped, replaced, added or assumed.
        warnings: likely mistakes in the file, each with a remedy.
        motors_stated: whether the file states which joints have motors.
    """

    name: str
    root: Body
    couplings: list[Coupling] = field(default_factory=list)
    closures: list[Closure] = field(default_factory=list)
    tendons: list[Tendon] = field(default_factory=list)
    excludes: list[tuple[str, str]] = field(default_factory=list)
    stand: tuple[Place, dict[str, float]] | None = None
    repairs: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    motors_stated: bool = False

    def rescale(self, length: float, mass: float) -> None:
        """Multiply all lengths and all masses.

        Inertias, also those of rotors (armature), are multiplied by `mass` and the square of
        `length`, as the file states them in the same units. Forces, torques and angles stay.
        """
        for body in self.root.walk():
            places = [body.place, *(shape.place for shape in body.shapes), *body.sites.values()]
            for place in places:
                place.position = length * place.position
            body.centre = length * body.centre
            body.mass *= mass
            body.inertia = mass * length**2 * body.inertia
            for shape in body.shapes:
                shape.size = length * shape.size
                shape.vertices = None if shape.vertices is None else length * shape.vertices
            for joint in body.joints:
                joint.rescale(length, mass)
        if self.stand is not None:
            place, angles = self.stand
            place.position = length * place.position
            for joint in self.joints:
                if joint.kind == "slide" and joint.name in angles:
                    angles[joint.name] *= length
        if length != 1:
            self.repairs.append(f"lengths multiplied by {length:g}")
        if mass != 1:
            self.repairs.append(f"masses multiplied by {mass:g}")

    @property
    def mass(self) -> float:
        """Mass of the robot, kg."""
        return sum(body.mass for body in self.root.walk())

    @property
    def joints(self) -> list[TreeJoint]:
        """All joints, parents first."""
        return [joint for body in self.root.walk() for joint in body.joints]


def report(repairs: list[str], what: str, names: Sequence[str]) -> None:
    """Add a repair with the names that it applies to, if any."""
    if names:
        repairs.append(f"{what}: {format_names(names)}")


def write(robot: RobotTree) -> str:
    """Return the robot's text; add the renamed joints to the robot's repairs."""
    return _Writer(robot).text()


class _Writer:
    def __init__(self, robot: RobotTree) -> None:
        self._robot = robot
        self._meshes = Element("asset")
        self._used: dict[str, set[str]] = {"body": {"world"}}  # reserved by MuJoCo
        # Writing the bodies makes their names unique; constraints then refer to the new names.
        self._bodies: dict[str, str] = {}
        self._joints: dict[str, str] = {}
        self._taut: list[str] = []

    def text(self) -> str:
        robot = self._robot
        root = Element("mujoco", model=_clean(robot.name) or "robot")
        SubElement(root, "compiler", angle="radian")
        world = Element("worldbody")
        self._body(world, robot.root)
        if len(self._meshes):
            root.append(self._meshes)
        root.append(world)
        self._excludes(root)
        self._tendons(root)
        self._equalities(root)
        self._motors(root)
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

    def _body(self, parent: Element, body: Body) -> None:
        name = self._bodies[body.name] = self._name("body", body.name)
        element = SubElement(parent, "body", {"name": name} | _place(body.place))
        if body is self._robot.root:
            SubElement(element, "freejoint", name=self._name("joint", name))
        inertial = {"pos": _numbers(body.centre), "mass": _number(body.mass)}
        SubElement(element, "inertial", inertial | _inertia(body.inertia))
        for joint in body.joints:
            new = self._joints[joint.name] = self._name("joint", joint.name)
            if new != joint.name:
                self._robot.repairs.append(
                    f"joint {joint.name[:100]!r} renamed to {new!r}: names must be unique and "
                    "printable, and must not look like a formula"
                )
            SubElement(element, "joint", {"name": new} | _joint(joint))
        for shape in body.shapes:
            self._shape(element, shape)
        for site, place in body.sites.items():
            SubElement(element, "site", {"name": site} | _place(place))
        for child in body.children:
            self._body(element, child)

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

    def _excludes(self, root: Element) -> None:
        names, excludes = self._bodies, self._robot.excludes
        pairs = sorted({(names[first], names[second]) for first, second in excludes})
        if pairs:
            contact = SubElement(root, "contact")
            for first, second in pairs:
                SubElement(contact, "exclude", body1=first, body2=second)

    def _equalities(self, root: Element) -> None:
        robot = self._robot
        if not (robot.couplings or robot.closures or self._taut):
            return
        equality = SubElement(root, "equality")
        for coupling in robot.couplings:
            values = _numbers((*coupling.coefficients, 0.0, 0.0, 0.0, 0.0, 0.0)[:5])
            follower, leader = (self._joints[one] for one in (coupling.follower, coupling.leader))
            SubElement(equality, "joint", joint1=follower, joint2=leader, polycoef=values)
        for closure in robot.closures:
            SubElement(equality, closure.kind, site1=closure.first, site2=closure.second)
        for name in self._taut:
            SubElement(equality, "tendon", tendon1=name)

    def _tendons(self, root: Element) -> None:
        tendons = SubElement(root, "tendon") if self._robot.tendons else root
        for tendon in self._robot.tendons:
            values = {key: _numbers(value) for key, value in tendon.attributes.items()}
            name = self._joints.get(tendon.pulley) or self._name("tendon", tendon.name)
            fixed = SubElement(tendons, "fixed", {"name": name} | values)
            self._taut += [name] * tendon.taut
            for joint, factor in tendon.joints:
                SubElement(fixed, "joint", joint=self._joints[joint], coef=_number(factor))

    def _motors(self, root: Element) -> None:
        driven = [joint.name for joint in self._robot.joints if joint.driven]
        if self._robot.motors_stated or len(driven) < len(self._robot.joints):
            motors = SubElement(root, "actuator")
            radii = {one.pulley: one.radius for one in self._robot.tendons}
            for name in driven:
                target = {"joint": self._joints[name]}
                if name in radii:
                    target = {"tendon": self._joints[name], "gear": _number(1 / radii[name])}
                SubElement(motors, "motor", target)

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


def _joint(joint: TreeJoint) -> dict[str, str]:
    found = {"axis": _numbers(joint.axis)}
    if joint.kind == "slide":
        found["type"] = "slide"
    if np.abs(joint.position).max() > 1e-9:
        found["pos"] = _numbers(joint.position)
    if joint.range is not None:
        found["range"] = _numbers(joint.range)
    if joint.torque > 0:
        found["actuatorfrcrange"] = _numbers((-joint.torque, joint.torque))
    servo = joint.speed, joint.servo_stiffness, joint.servo_damping
    if any(servo):
        found["user"] = _numbers(servo[: 3 if any(servo[1:]) else 1])
    for key, value in (
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
    values = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
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
