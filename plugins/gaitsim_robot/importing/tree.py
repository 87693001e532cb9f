"""A robot during its import: a tree of bodies that readers build and repairs modify."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
class Joint:
    """A joint between a body and its parent.

    Attributes:
        name: name of the joint.
        kind: hinge, slide, ball or free.
        axis, position: axis and position in the body, (3,).
        range: smallest and largest angle, rad; None if the file has no limits.
        torque: largest torque, N·m; 0 if unknown.
        speed: largest speed, rad/s; 0 if unknown.
        damping, armature, friction, stiffness, reference, spring_reference: MuJoCo's attributes.
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
    """

    name: str
    place: Place = field(default_factory=Place)
    mass: float = 0.0
    centre: Floats = field(default_factory=lambda: np.zeros(3))
    inertia: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    shapes: list[Shape] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    sites: dict[str, Place] = field(default_factory=dict)
    children: list["Body"] = field(default_factory=list)
    lost: bool = False

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


@dataclass(eq=False)
class Robot:
    """A robot.

    Attributes:
        name: name of the robot.
        root: the trunk.
        couplings: mimic joints.
        closures: closed linkages and welds.
        excludes: pairs of names of bodies that never touch.
        stand: place of the trunk and joint angles, rad, in the keyframe; None without a keyframe.
        repairs: descriptions of everything that was dropped, replaced, added or assumed.
    """

    name: str
    root: Body
    couplings: list[Coupling] = field(default_factory=list)
    closures: list[Closure] = field(default_factory=list)
    excludes: list[tuple[str, str]] = field(default_factory=list)
    stand: tuple[Place, dict[str, float]] | None = None
    repairs: list[str] = field(default_factory=list)

    @property
    def joints(self) -> list[Joint]:
        """All joints, parents first."""
        return [joint for body in self.root.walk() for joint in body.joints]


def format_names(names: Sequence[str], limit: int = 4) -> str:
    """Return a text with the first names and the number of the others."""
    more = len(names) - limit
    shown = ", ".join(repr(name) for name in names[:limit])
    return f"{shown} and {more} more" if more > 0 else shown
