"""One body over time as a scene shows it: poses between frames, and the aim of the camera."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton, Terrain
from gaitsim.errors import GaitsimError
from gaitsim.render.scene.anatomy import Anatomy, anatomy
from gaitsim.render.scene.camera import Points, steadied
from gaitsim.render.scene.solids import Surfaces, between_poses

FOOT, SOLE = 1.55, 2.2  # radius of a foot's mark, in those of limbs and of solid feet


@dataclass(frozen=True, eq=False)
class Pose:
    """A body at one moment, above the floor.

    Attributes:
        segments: (segments, 2, 3) m.
        solids: position, m, and quaternion of each solid, (solids, 7).
        contacts: (contacts, 3) m, none where the body has none.
        touching: which of them do, (contacts,).
        middle: where the body is, (3,) m.
        aim: where the camera looks but for the framing, (3,) m.
        trail: where it has been, its own place last, (points, 3) m.
    """

    segments: Points
    solids: Points
    contacts: Points
    touching: NDArray[np.bool_]
    middle: Points
    aim: Points
    trail: Points


@dataclass(frozen=True, eq=False)
class Clip:
    """A skeleton to show, with its captions.

    Attributes:
        skeleton: whose numbers are finite.
        title: the first line.
        details: the second.
        tag: a word beside the body, where there are others.
        lane: how far it is moved to the left, m.
        depth: height of the drawn ground, m; None for its own.
        named: whether the names of its feet are written beside them.

    Raises:
        GaitsimError: the skeleton cannot be drawn.
    """

    skeleton: Skeleton
    title: str = ""
    details: str = ""
    tag: str = ""
    lane: float = 0.0
    depth: float | None = None
    named: bool = False

    def __post_init__(self) -> None:
        segments, contacts = self.skeleton.segments, self.skeleton.contacts
        if not segments.size:
            raise GaitsimError(
                f"the body has nothing to draw: {segments.shape[0]} frames of "
                f"{segments.shape[1]} segments",
                allowed="a skeleton of one frame and one segment or more",
            )
        places = (segments, self.skeleton.path, contacts, self.skeleton.poses)
        if not all(np.isfinite(one).all() for one in places if one is not None):
            raise GaitsimError(
                "the body's skeleton holds numbers that are not finite",
                remedy="tell the author of the body; another generation may be drawn",
            )
        if not 0 < self.skeleton.frame_rate < np.inf:
            raise GaitsimError(
                f"the body moves at {self.skeleton.frame_rate} frames a second", allowed="above 0"
            )

    @property
    def flies(self) -> bool:
        """Whether it has no feet."""
        return self.skeleton.contacts is None

    @cached_property
    def anatomy(self) -> Anatomy:
        """How to draw it."""
        return anatomy(self.skeleton)

    @cached_property
    def surfaces(self) -> Surfaces:
        """The surfaces of its solids."""
        return Surfaces(self.skeleton.solids)

    @cached_property
    def carriers(self) -> list[int]:
        """The solid that each contact is on, of a body that has solids."""
        if not self.skeleton.solids:
            return []
        pose = self.at(0)
        placed = self.surfaces.placed(pose.solids)
        away = np.linalg.norm(placed - pose.contacts[:, None], axis=-1)
        return [int(solid) for solid in self.surfaces.owner[away.argmin(axis=1)]]

    @cached_property
    def mark(self) -> float:
        """The radius of a foot's mark on the ground, m."""
        each = self.surfaces.each
        thin = [float(np.ptp(each[solid].points, axis=0).min()) / 2 for solid in self.carriers]
        return max(FOOT * self.anatomy.thickness, SOLE * float(np.median(thin)) if thin else 0.0)

    def points(self, pose: Pose) -> Points:
        """Return the points that span it in a pose, (points, 3) m."""
        ends = pose.segments.reshape(-1, 3)
        return np.concatenate([ends, self.surfaces.placed(pose.solids)])

    @property
    def planar(self) -> bool:
        """Whether it moves in a vertical plane along x, so that it is a line from above."""
        return float(np.ptp(self.box[:, 1])) < 1e-6 * self.anatomy.span

    @cached_property
    def path(self) -> Points:
        """Its path in its lane above the floor, (frames, 3) m."""
        return np.asarray(self.skeleton.path, dtype=np.float64) + self._shift

    @cached_property
    def seconds(self) -> float:
        """The time from the first frame to the last."""
        return (len(self.path) - 1) / self.skeleton.frame_rate

    @cached_property
    def floor(self) -> float:
        """Height of the drawn ground, m: below a flying body, whose zero is its start."""
        if self.depth is not None:
            return self.depth
        return min(0.0, float(self.skeleton.segments[..., 2].min())) if self.flies else 0.0

    def grounded(self, points: Points) -> Points:
        """Move points (…, 3) up or down to the drawn ground."""
        ground = self.skeleton.ground
        if isinstance(ground, Terrain):
            height = ground.height(points)
        else:
            height = np.zeros(1) if ground is None else np.interp(points[..., 0], *ground.T)
        return np.stack(np.broadcast_arrays(points[..., 0], points[..., 1], height), axis=-1)

    @cached_property
    def corners(self) -> tuple[Points, Points]:
        """The x and the y of the corners of the ground, (corners,) m each."""
        ground = self.skeleton.ground
        if isinstance(ground, Terrain):
            return ground.corners
        x = np.empty(0) if ground is None else ground[:, 0].astype(np.float64)
        return x, np.empty(0)

    @cached_property
    def box(self) -> Points:
        """Its points about its path at up to 100 moments, (points, 3) m."""
        every = np.unique(np.linspace(0, len(self.path) - 1, 100).astype(int))
        poses = [self.at(frame / self.skeleton.frame_rate) for frame in every.tolist()]
        return np.concatenate([self.points(pose) - pose.aim for pose in poses])

    @property
    def _shift(self) -> Points:
        return np.array([0.0, self.lane, -self.floor])

    @cached_property
    def _aims(self) -> Points:
        return steadied(self.path, self.skeleton.frame_rate)

    def at(self, seconds: float) -> Pose:
        """Return the pose at a time, interpolated between frames; after the end, the last one."""
        place = min(max(seconds, 0.0) * self.skeleton.frame_rate, len(self.path) - 1.0)
        # Snap to a frame that differs only by rounding.
        place = round(place) if abs(place - round(place)) < 1e-6 else place
        before = int(place)
        share = place - before

        def between(values: NDArray[np.floating[Any]]) -> Points:
            one = np.asarray(values[before], dtype=np.float64)
            return one + share * (values[before + 1] - one) if share else one

        skeleton = self.skeleton
        middle = between(self.path)
        contacts, touching = np.empty((0, 3)), np.empty(0, dtype=np.bool_)
        if skeleton.contacts is not None and skeleton.touching is not None:
            contacts, touching = between(skeleton.contacts), skeleton.touching[before]
        return Pose(
            between(skeleton.segments) + self._shift,
            self._solids(before, share),
            contacts + self._shift,
            touching,
            middle,
            between(self._aims),
            np.concatenate([self.path[: before + 1], middle[None]]),
        )

    def _solids(self, before: int, share: float) -> Points:
        """Return the poses of the solids a share of the way from a frame to the next."""
        if self.skeleton.poses is None:
            return np.empty((0, 7))
        poses = np.asarray(self.skeleton.poses[before : before + 2], dtype=np.float64)
        found = between_poses(poses[0], poses[1], share) if share else poses[0].copy()
        found[:, :3] += self._shift
        return found
