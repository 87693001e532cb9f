"""One body in motion for a scene: poses between frames, and the aim of the camera."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton, Terrain
from gaitsim.errors import GaitsimError
from gaitsim.render.scene.anatomy import Anatomy, anatomy
from gaitsim.render.scene.camera import Points, smooth_path
from gaitsim.render.scene.solids import Surfaces, interpolate_poses

FOOT, SOLE = 1.55, 2.2  # radius of a foot's mark, relative to limbs and to solid feet


@dataclass(frozen=True, eq=False)
class Pose:
    """A body at one moment, relative to the floor.

    Attributes:
        segments: (segments, 2, 3) m.
        solids: position, m, and quaternion of each solid, (solids, 7).
        contacts: positions of the contacts, (contacts, 3) m; empty for a body without contacts.
        touching: whether each contact touches the ground, (contacts,).
        middle: position of the body, (3,) m.
        aim: aim of the camera, before framing, (3,) m.
        trail: path up to the current position, (points, 3) m.
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
        skeleton: skeleton with finite numbers.
        title: first line of text.
        details: second line of text.
        tag: word beside the body, to distinguish several.
        lane: displacement to the left, m.
        depth: height of the drawn ground, m; None derives it from the skeleton.
        named: whether to write the names of the feet beside them.
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
                allowed="a skeleton with at least one frame and one segment",
            )
        places = (segments, self.skeleton.path, contacts, self.skeleton.poses)
        if not all(np.isfinite(one).all() for one in places if one is not None):
            raise GaitsimError(
                "the body's skeleton contains numbers that are not finite",
                remedy="choose a different generation, or report it to the author of the body",
            )
        if not 0 < self.skeleton.frame_rate < np.inf:
            raise GaitsimError(
                f"the frame rate of the body is {self.skeleton.frame_rate} Hz", allowed="above 0"
            )

    @property
    def flies(self) -> bool:
        """Whether the body has no feet."""
        return self.skeleton.contacts is None

    @cached_property
    def anatomy(self) -> Anatomy:
        """The drawn shape of the skeleton."""
        return anatomy(self.skeleton)

    @cached_property
    def surfaces(self) -> Surfaces:
        """The surfaces of the skeleton's solids."""
        return Surfaces(self.skeleton.solids)

    @cached_property
    def foot_solids(self) -> list[int]:
        """The index of the solid nearest to each contact; empty for a body without solids."""
        if not self.skeleton.solids:
            return []
        pose = self.at(0)
        placed = self.surfaces.points_at(pose.solids)
        away = np.linalg.norm(placed - pose.contacts[:, None], axis=-1)
        return [int(solid) for solid in self.surfaces.owner[away.argmin(axis=1)]]

    @cached_property
    def mark(self) -> float:
        """The radius of a foot's mark on the ground, m."""
        each = self.surfaces.each
        thin = [float(np.ptp(each[solid].points, axis=0).min()) / 2 for solid in self.foot_solids]
        return max(FOOT * self.anatomy.thickness, SOLE * float(np.median(thin)) if thin else 0.0)

    def points(self, pose: Pose) -> Points:
        """Return the points that span the body in a pose, (points, 3) m."""
        ends = pose.segments.reshape(-1, 3)
        return np.concatenate([ends, self.surfaces.points_at(pose.solids)])

    @property
    def planar(self) -> bool:
        """Whether the body moves in a vertical plane along x and is a line from above."""
        return float(np.ptp(self.box[:, 1])) < 1e-6 * self.anatomy.span

    @cached_property
    def path(self) -> Points:
        """The path of the body in its lane, relative to the floor, (frames, 3) m."""
        return np.asarray(self.skeleton.path, dtype=np.float64) + self._shift

    @cached_property
    def seconds(self) -> float:
        """The time from the first frame to the last."""
        return (len(self.path) - 1) / self.skeleton.frame_rate

    @cached_property
    def floor(self) -> float:
        """Height of the drawn ground, m; a flying body, which starts at 0, may fall below 0."""
        if self.depth is not None:
            return self.depth
        return min(0.0, float(self.skeleton.segments[..., 2].min())) if self.flies else 0.0

    def on_ground(self, points: Points) -> Points:
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
        """The body's points relative to its path, at up to 100 moments, (points, 3) m."""
        every = np.unique(np.linspace(0, len(self.path) - 1, 100).astype(int))
        poses = [self.at(frame / self.skeleton.frame_rate) for frame in every.tolist()]
        return np.concatenate([self.points(pose) - pose.aim for pose in poses])

    @property
    def _shift(self) -> Points:
        return np.array([0.0, self.lane, -self.floor])

    @cached_property
    def _aims(self) -> Points:
        return smooth_path(self.path, self.skeleton.frame_rate)

    def at(self, seconds: float) -> Pose:
        """Return the pose at a time, interpolated between frames; the last pose after the end."""
        place = min(max(seconds, 0.0) * self.skeleton.frame_rate, len(self.path) - 1.0)
        # Remove rounding errors in the number of a frame.
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
        """Return the poses of the solids, interpolated between a frame and the next."""
        if self.skeleton.poses is None:
            return np.empty((0, 7))
        poses = np.asarray(self.skeleton.poses[before : before + 2], dtype=np.float64)
        found = interpolate_poses(poses[0], poses[1], share) if share else poses[0].copy()
        found[:, :3] += self._shift
        return found
