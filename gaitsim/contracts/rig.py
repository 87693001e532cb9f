"""A body as a tree of links that joints turn: what places it by its joint angles alone."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts.quaternions import Floats, product, rotated, turn_about
from gaitsim.contracts.solid import SkeletonError, Solid

_UNIT = 1e-6  # farthest from 1 that the length of an axis or a quaternion may be


@dataclass(frozen=True)
class Link:
    """A rigid part of a body, and how it hangs on another one.

    Args:
        name: of the link.
        parent: name of the link that carries it; '' for the trunk.
        origin: of its frame, in its parent's frame, (3,) m: a point on the joint's axis.
        rotation: of its frame in its parent's where the joint is at zero, (w, x, y, z). The
            trunk's is its own in the body's frame: x forward, y left, z up.
        joint: name of the joint that turns it about its origin; '' for a link that is fixed.
        axis: about which a positive angle turns it, in its own frame, of length 1, (3,).
    """

    name: str
    parent: str = ""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    joint: str = ""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Placed:
    """What a rig carries at some joint angles, in the body's frame.

    Attributes:
        segments: both ends of each segment, (…, segments, 2, 3) m.
        poses: position, m, and unit quaternion of each solid, (…, solids, 7).
        feet: (…, feet, 3) m.
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
        links: the trunk first, parents before children.
        joints: names of the joint angles, as `Organism.joint_names`. An angle may turn no link,
            such as that of a joint that is stuck, or several.
        names: name of each segment.
        segments: both ends of each segment, (segments, 2, 3) m.
        segment_links: name of the link of each segment.
        feet: points that touch the ground, (feet, 3) m; None without feet.
        foot_links: name of the link of each.
        foot_names: name of each, such as a leg's.
        solids: what the body is made of.
        solid_poses: position, m, and unit quaternion (w, x, y, z) of each, (solids, 7).
        solid_links: name of the link of each.
        damaged: names of what does not move as it should, as in the skeleton.

    Raises:
        SkeletonError: the parts do not fit each other, or are not finite.
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
                raise SkeletonError(f"Rig.{name} has shape {shape}, expected {expected}, finite")
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
                    f"Rig.links has a link {link.name!r}, expected a name of its own"
                )
            if (link.parent not in seen) if seen else link.parent:
                raise SkeletonError(
                    f"link {link.name!r} has the parent {link.parent!r}, expected '' for the first "
                    "link and one of those before it for every other"
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
                        f"link {link.name!r} has the {name} {values}, expected {count} numbers"
                    )
            for name in ("rotation", "axis"):
                length = float(np.linalg.norm(getattr(link, name)))
                if abs(length - 1) > _UNIT:
                    raise SkeletonError(
                        f"the {name} of link {link.name!r} has the length {length:.6g}, expected 1"
                    )
            seen.add(link.name)
        if not seen:
            raise SkeletonError("Rig.links is empty, expected the trunk at least")

    def place(self, angles: Floats) -> Placed:
        """Return where everything is at joint angles, (…, joints) rad, in the body's frame."""
        places, turns = self._placed_links(np.asarray(angles, np.float64))
        index = {link.name: number for number, link in enumerate(self.links)}

        def of(links: Iterable[str], points: Floats) -> tuple[Floats, Floats]:
            at = [index[name] for name in links]
            apart = (1,) * (points.ndim - 2)
            turn = turns[..., at, :].reshape(*turns.shape[:-2], len(at), *apart, 4)
            place = places[..., at, :].reshape(*places.shape[:-2], len(at), *apart, 3)
            return place + rotated(turn, points), turn

        solids = np.zeros((0, 7)) if self.solid_poses is None else self.solid_poses
        middles, carried = of(self.solid_links, solids[:, :3])
        return Placed(
            of(self.segment_links, self.segments)[0],
            np.concatenate([middles, product(carried, solids[:, 3:])], axis=-1),
            of(self.foot_links, np.zeros((0, 3)) if self.feet is None else self.feet)[0],
        )

    def _placed_links(self, angles: Floats) -> tuple[Floats, Floats]:
        """Return origins (…, links, 3), m, and rotations (…, links, 4) in the body's frame."""
        if angles.shape[-1:] != (len(self.joints),):
            raise ValueError(f"angles of shape {angles.shape}, expected (…, {len(self.joints)})")
        places = np.empty((*angles.shape[:-1], len(self.links), 3))
        turns = np.empty((*angles.shape[:-1], len(self.links), 4))
        index: dict[str, int] = {}
        for number, link in enumerate(self.links):
            place, turn = np.array(link.origin), np.array(link.rotation)
            if link.parent:
                above = index[link.parent]
                place = places[..., above, :] + rotated(turns[..., above, :], place)
                turn = product(turns[..., above, :], turn)
            if link.joint:
                by = turn_about(np.array(link.axis), angles[..., self.joints.index(link.joint)])
                turn = product(turn, by)
            places[..., number, :], turns[..., number, :] = place, turn
            index[link.name] = number
        return places, turns
