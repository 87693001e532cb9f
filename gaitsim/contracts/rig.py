"""A body as a kinematic tree: links whose positions depend only on the joint angles."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.quaternions import Floats, product, rotated, turn_about
from gaitsim.portable import norm

Shape = Literal["box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"]

_SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "mesh": 0}


class SkeletonError(ValueError):
    """Raised if the parts of a skeleton or a rig do not match each other."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid convex solid in its own frame; `Skeleton.poses` gives its place in the world.

    Args:
        name: name of the part of the body. If its first word, without a number, is L, R, left,
            right, near or far, as in 'L1 tibia', the solid has the colour of that side.
        shape: one of box, sphere, capsule, cylinder, ellipsoid, mesh.
        size: lengths in metres, as in MuJoCo. Box: half lengths along x, y and z. Sphere: radius.
            Capsule and cylinder: radius, and half length along z, without the round ends of a
            capsule. Ellipsoid: three radii. Mesh: ().
        vertices: points of a mesh, (points, 3), metres; the solid is their convex hull.

    Raises:
        SkeletonError: the shape is unknown, or `size` or `vertices` do not match it.
    """

    name: str
    shape: Shape
    size: tuple[float, ...] = ()
    vertices: NDArray[np.floating[Any]] | None = None

    def __post_init__(self) -> None:
        if self.shape not in get_args(Shape):
            raise SkeletonError(
                f"solid {self.name!r} has the shape {self.shape!r}, "
                f"expected one of {', '.join(get_args(Shape))}"
            )
        count = _SIZES[self.shape]
        if np.shape(self.size) != (count,) or not all(0 < length < np.inf for length in self.size):
            expected = f"{count} lengths above 0" if count else "()"
            raise SkeletonError(
                f"solid {self.name!r}, a {self.shape}, has the size {self.size}, "
                f"expected {expected}"
            )
        if (self.shape == "mesh") != (self.vertices is not None):
            raise SkeletonError(
                f"solid {self.name!r} is a {self.shape}: a mesh must have vertices, and no other "
                "shape may"
            )
        points = self.vertices
        if points is None:
            return
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
            raise SkeletonError(
                f"solid {self.name!r} has vertices of shape {points.shape}, expected "
                "(points, 3) with at least 4 points"
            )
        if not np.isfinite(points).all():
            raise SkeletonError(f"solid {self.name!r} has vertices that are not finite")


_UNIT = 1e-6  # tolerance for the length of an axis or a quaternion, which must be 1


@dataclass(frozen=True)
class Link:
    """A rigid part of a body, and its connection to its parent.

    Args:
        name: name of the link.
        parent: name of the link that carries this one; '' for the trunk.
        origin: origin of the link's frame in the frame of the parent, (3,) m. It lies on the
            axis of the link's joint.
        rotation: rotation of the link's frame relative to the parent's when the joint angle is
            zero, a quaternion (w, x, y, z). For the trunk, it is relative to the frame of the body:
            x forward, y left, z up.
        joint: name of the joint that turns the link about its origin; '' for a fixed link.
        axis: unit vector about which a positive angle turns the link, in its own frame, (3,).
    """

    name: str
    parent: str = ""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    joint: str = ""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class PlacedParts:
    """The segments, solids and feet of a rig at given joint angles, in the frame of the body.

    Attributes:
        segments: both ends of each segment, (…, segments, 2, 3) m.
        poses: position, m, and unit quaternion of each solid, (…, solids, 7).
        feet: position of each foot, (…, feet, 3) m.
    """

    segments: Floats
    poses: Floats
    feet: Floats


@dataclass(frozen=True, eq=False)
class Rig:
    """The kinematic tree of a body: links, and the segments, solids and feet on each.

    Segments, solids and feet are those of the body's `Skeleton`, in the same order, each in the
    frame of its link.

    Args:
        links: links of the body: the trunk first, parents before children.
        joints: names of the joint angles, as `Organism.joint_names` returns them. An angle may
            turn several links, or none if its joint is stuck.
        names: name of each segment.
        segments: both ends of each segment, (segments, 2, 3) m.
        segment_links: name of the link that carries each segment.
        feet: points that touch the ground, (feet, 3) m; None for a body without feet.
        foot_links: name of the link that carries each foot.
        foot_names: name of each foot, such as the name of its leg.
        solids: rigid solids of the body.
        solid_poses: position, m, and unit quaternion (w, x, y, z) of each solid, (solids, 7).
        solid_links: name of the link that carries each solid.
        damaged: names of damaged parts, as in `Skeleton`.

    Raises:
        SkeletonError: the parts do not match each other, or are not finite.
    """

    links: tuple[Link, ...]
    joints: tuple[str, ...]
    names: tuple[str, ...]
    segments: Floats
    segment_links: tuple[str, ...]
    feet: Floats | None = None
    foot_links: tuple[str, ...] = ()
    foot_names: tuple[str, ...] = ()
    solids: tuple[Solid, ...] = ()
    solid_poses: Floats | None = None
    solid_links: tuple[str, ...] = ()
    damaged: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self._check_links()
        feet, solids = len(self.foot_names), len(self.solids)
        for name, array, expected in (
            ("segments", self.segments, (len(self.names), 2, 3)),
            ("feet", self.feet, (feet, 3) if feet else None),
            ("solid_poses", self.solid_poses, (solids, 7) if solids else None),
        ):
            shape = None if array is None else np.shape(array)
            if shape != expected or (array is not None and not np.isfinite(array).all()):
                raise SkeletonError(
                    f"Rig.{name} has shape {shape}, expected finite numbers of shape {expected}"
                )
        known = {link.name for link in self.links}
        for name, links, count in (
            ("segment_links", self.segment_links, len(self.names)),
            ("foot_links", self.foot_links, feet),
            ("solid_links", self.solid_links, solids),
        ):
            if len(links) != count:
                raise SkeletonError(f"Rig.{name} has {len(links)} names, expected {count}")
            if unknown := [*{*links} - known]:
                raise SkeletonError(f"Rig.{name} has {unknown}: not a link")

    def _check_links(self) -> None:
        seen: set[str] = set()
        for link in self.links:
            if not link.name or link.name in seen:
                raise SkeletonError(
                    f"Rig.links has a link {link.name!r}, expected a unique, non-empty name"
                )
            if (link.parent not in seen) if seen else link.parent:
                raise SkeletonError(
                    f"link {link.name!r} has the parent {link.parent!r}, expected '' for the first "
                    "link and an earlier link for every other one"
                )
            if link.joint and link.joint not in self.joints:
                raise SkeletonError(
                    f"link {link.name!r} has the joint {link.joint!r}, expected one of "
                    f"{', '.join(self.joints)}, or ''"
                )
            for name, count in (("origin", 3), ("rotation", 4), ("axis", 3)):
                values = getattr(link, name)
                if np.shape(values) != (count,) or not np.isfinite(values).all():
                    raise SkeletonError(
                        f"link {link.name!r} has the {name} {values}, expected {count} finite "
                        "numbers"
                    )
            for name in ("rotation", "axis"):
                length = float(norm(getattr(link, name)))
                if abs(length - 1) > _UNIT:
                    raise SkeletonError(
                        f"the {name} of link {link.name!r} has the length {length:.6g}, expected 1"
                    )
            seen.add(link.name)
        if not seen:
            raise SkeletonError("Rig.links is empty, expected at least the trunk")

    def place(self, angles: Floats) -> PlacedParts:
        """Return the positions of all parts at given joint angles, (…, joints), rad.

        Raises:
            ValueError: the number of angles is not the number of joints.
        """
        origins, rotations = self._link_frames(np.asarray(angles, np.float64))
        index = {link.name: number for number, link in enumerate(self.links)}

        def transform(links: Iterable[str], points: Floats) -> tuple[Floats, Floats]:
            """Return points of links in the frame of the body, and the links' rotations."""
            at = [index[name] for name in links]
            ones = (1,) * (points.ndim - 2)
            turns = rotations[..., at, :].reshape(*rotations.shape[:-2], len(at), *ones, 4)
            places = origins[..., at, :].reshape(*origins.shape[:-2], len(at), *ones, 3)
            return places + rotated(turns, points), turns

        solids = np.zeros((0, 7)) if self.solid_poses is None else self.solid_poses
        middles, turns = transform(self.solid_links, solids[:, :3])
        return PlacedParts(
            transform(self.segment_links, self.segments)[0],
            np.concatenate([middles, product(turns, solids[:, 3:])], axis=-1),
            transform(self.foot_links, np.zeros((0, 3)) if self.feet is None else self.feet)[0],
        )

    def _link_frames(self, angles: Floats) -> tuple[Floats, Floats]:
        """Return origins (…, links, 3), m, and rotations (…, links, 4) in the frame of the body."""
        if angles.shape[-1:] != (len(self.joints),):
            raise ValueError(f"angles have shape {angles.shape}, expected (…, {len(self.joints)})")
        places = np.empty((*angles.shape[:-1], len(self.links), 3))
        turns = np.empty((*angles.shape[:-1], len(self.links), 4))
        index: dict[str, int] = {}
        for number, link in enumerate(self.links):
            place, turn = np.array(link.origin), np.array(link.rotation)
            if link.parent:
                parent = index[link.parent]
                place = places[..., parent, :] + rotated(turns[..., parent, :], place)
                turn = product(turns[..., parent, :], turn)
            if link.joint:
                angle = angles[..., self.joints.index(link.joint)]
                turn = product(turn, turn_about(np.array(link.axis), angle))
            places[..., number, :], turns[..., number, :] = place, turn
            index[link.name] = number
        return places, turns
