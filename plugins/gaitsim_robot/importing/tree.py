"""A robot while it is imported: a tree of bodies, which readers build and repairs change."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(eq=False)
class Place:
    """A frame within another one.

    Attributes:
        position: (3,) m.
        rotation: (3, 3), its columns are the frame's axes.
    """

    position: Floats = field(default_factory=lambda: np.zeros(3))
    rotation: Floats = field(default_factory=lambda: np.eye(3))

    def __matmul__(self, inner: "Place") -> "Place":
        """Return the place of `inner`, given in this frame, in this frame's own parent."""
        return Place(self.point(inner.position), self.rotation @ inner.rotation)

    def point(self, points: Floats) -> Floats:
        """Return points of this frame, (…, 3), in its parent."""
        return points @ self.rotation.T + self.position

    def inverse(self) -> "Place":
        """Return the parent's place in this frame."""
        return Place(-self.position @ self.rotation, self.rotation.T)


@dataclass(eq=False)
class Shape:
    """A solid of a body.

    Attributes:
        kind: sphere, capsule, ellipsoid, cylinder, box or mesh.
        place: in the body.
        size: as MuJoCo has it (half lengths), m.
        vertices: of a mesh, in the shape's frame, (n, 3) m.
        collides: whether it is a collision geometry; otherwise only seen.
        contype, conaffinity: MuJoCo's bits of contacts.
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
        kind: hinge, slide, ball or free.
        axis, position: in the body, (3,).
        range: rad; None where the file has none.
        torque: the largest, N·m; 0 where it is not known.
        speed: the largest, rad/s; 0 where it is not known.
        damping, armature, friction, stiffness, reference, spring_reference: as MuJoCo has them.
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
        place: in the parent.
        mass: kg.
        centre: of mass, in the body, (3,) m.
        inertia: about the centre of mass, along the body's axes, (3, 3) kg·m².
        sites: frames that equality constraints refer to.
        lost: whether geometry that collides is missing.
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
        waiting = [self]
        while waiting:
            body = waiting.pop()
            yield body
            waiting += reversed(body.children)

    @property
    def colliding(self) -> list[Shape]:
        """Its collision geometry."""
        return [shape for shape in self.shapes if shape.collides]


@dataclass(frozen=True)
class Coupling:
    """Joint `follower` follows `leader`: angle = Σ coefficients · leader^power."""

    follower: str
    leader: str
    coefficients: tuple[float, ...]


@dataclass(frozen=True)
class Closure:
    """Two sites that coincide: a closed linkage (`connect`), or rigidly (`weld`)."""

    kind: str
    first: str
    second: str


@dataclass(eq=False)
class Robot:
    """A robot.

    Attributes:
        excludes: pairs of names of bodies that never touch.
        stand: angles of joints in the keyframe, rad, with the trunk's place; None without one.
        repairs: what was dropped, replaced, added or assumed.
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


def listed(names: Sequence[str], limit: int = 4) -> str:
    """Return the first names and how many more there are."""
    more = len(names) - limit
    shown = ", ".join(repr(name) for name in names[:limit])
    return f"{shown} and {more} more" if more > 0 else shown
