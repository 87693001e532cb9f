"""Bodies in motion for a scene: poses between frames, lanes of a race, the aim of the camera."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import COMMAND, Skeleton, Terrain
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.registry import contract_error
from gaitsim.render.scene.bodies import DrawnAnatomy, anatomy
from gaitsim.render.scene.camera import Points, axes as camera_axes, smooth_path
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
        named: whether to write the names of the feet beside them, and to point to the front.
        pins: places marked by white circles in the first frame, (pins, 3) m; None for none.
        said: what a driver commands in each frame, (frames,); () without a driver.
    """

    skeleton: Skeleton
    title: str = ""
    details: str = ""
    tag: str = ""
    lane: float = 0.0
    depth: float | None = None
    named: bool = False
    pins: Points | None = None
    said: tuple[str, ...] = ()

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
    def anatomy(self) -> DrawnAnatomy:
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
        placed = np.array(points, dtype=np.float64)
        placed[..., 2] = height
        return placed

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
            if share:  # a foot that lands or lifts between two frames is in the air
                touching = touching & skeleton.touching[before + 1]
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


def clip_of(individual: Individual, title: str = "", details: str = "", tag: str = "") -> Clip:
    """Return the clip of an individual, with its captions."""
    skeleton = individual.skeleton
    try:
        return Clip(skeleton, title, details, tag, said=_said(individual))
    except GaitsimError as error:
        entry = individual.experiment.entries["organism"]
        raise contract_error(
            entry, f"has a skeleton that cannot be drawn: {error.what}", error.allowed
        ) from None


def _said(individual: Individual) -> tuple[str, ...]:
    """Return the commands of a driven individual in each frame; () without a driver."""
    if not getattr(individual.experiment.organism, "drive", ()):
        return ()
    axes = individual.experiment.organism.channels.get("command")
    if axes is None or axes.axes != ("frames", COMMAND):
        return ()
    return tuple(map(format_command, individual.motion["command"][0].tolist()))


def format_command(command: Sequence[float]) -> str:
    """Format a command, in the order of `COMMAND`, such as 'command 0.20 m/s, 30 °/s left'."""
    speed, turn, sideways, height = command
    degrees = round(math.degrees(turn))
    parts = [f"{round(speed, 2) + 0.0:.2f} m/s"]  # without −0.00
    if degrees:
        parts.append(f"{abs(degrees)} °/s {_side(turn)}")
    if round(sideways, 2):
        parts.append(f"{abs(sideways):.2f} m/s {_side(sideways)}")
    if round(height, 3):
        parts.append(f"{100 * height:+.1f} cm")
    return f"command {', '.join(parts)}".replace("-", "−")


def _side(value: float) -> str:
    return "left" if value > 0 else "right"


MOMENTS = 100  # number of moments at which the bodies are measured
LANE_GAP = 0.15  # gap between bodies side by side, in body widths
TAG_GAP = 0.3  # gap between bodies in the picture of the start, for their tags, in body sizes
MAX_LANE = (
    3.0  # maximum width of a lane, in body widths; bodies that drift farther leave their lane
)


class Race:
    """One body, or several in lanes, of which the first is the farthest from the camera.

    Args:
        clips: bodies in motion.
        leader: index of the clip that stays visible when the bodies are too far apart to show all.
        angles: azimuth and elevation of the camera, degrees.

    Attributes:
        clips: the clips in their lanes, on a common ground.
        room: maximum distance of the leader from the aim of the camera, m.
    """

    def __init__(self, clips: Sequence[Clip], leader: int, angles: tuple[float, float]) -> None:
        self.clips = _in_lanes(clips, angles) if len(clips) > 1 else list(clips)
        self.leader, self.room = leader, np.inf
        self.seconds = max(clip.seconds for clip in clips)
        self.span = max(clip.anatomy.span for clip in clips)

    def aim(self, poses: Sequence[Pose]) -> Points:
        """Return the aim of the camera: the middle of the bodies, but near the leader."""
        aims = np.stack([pose.aim for pose in poses])
        middle = (aims.min(axis=0) + aims.max(axis=0)) / 2
        away = aims[self.leader] - middle
        far = float(np.linalg.norm(away))
        return np.asarray(middle + away * (1 - self.room / far) if far > self.room else middle)

    @property
    def box(self) -> Points:
        """The points of all bodies relative to the aim of the camera, (points, 3) m."""
        if len(self.clips) == 1:
            return self.clips[0].box
        points = []
        for seconds in np.linspace(0, self.seconds, MOMENTS):
            poses = [clip.at(seconds) for clip in self.clips]
            every = [clip.points(pose) for clip, pose in zip(self.clips, poses, strict=True)]
            points.append(np.concatenate(every) - self.aim(poses))
        return np.concatenate(points)


def _in_lanes(clips: Sequence[Clip], angles: tuple[float, float]) -> list[Clip]:
    """Return the clips side by side, at the distances that their movement requires.

    At the start, the bodies do not overlap in the picture either.
    """
    floor = min(clip.floor for clip in clips)
    wide = max(float(np.ptp(clip.box, axis=0)[1]) for clip in clips)
    right_axis, up_axis, _ = camera_axes(*angles)
    shift = np.array([right_axis[1], up_axis[1]])  # of a body one metre to the left, in the picture
    direction = (right_axis * shift[0] + up_axis * shift[1]) / (shift @ shift)
    starts = [(clip.points(clip.at(0.0)) - clip.path[0]) @ direction for clip in clips]
    gap = TAG_GAP * max(float(np.ptp(start)) for start in starts)
    moments = np.linspace(0, max(clip.seconds for clip in clips), MOMENTS)
    # Right and left edge of each body at each moment, (clips, moments).
    across = [[clip.points(clip.at(time))[:, 1] for time in moments] for clip in clips]
    right = np.array([[y.min() for y in clip] for clip in across])
    left = np.array([[y.max() for y in clip] for clip in across])
    lanes = [0.0]
    for number, (farther, nearer) in enumerate(zip(right[:-1], left[1:], strict=True)):
        step = float((nearer - farther).max()) + LANE_GAP * wide
        apart = float(starts[number + 1].max() - starts[number].min()) + gap
        lanes.append(lanes[-1] - max(min(step, MAX_LANE * wide), apart))
    middle = (lanes[0] + lanes[-1]) / 2
    return [
        replace(clip, lane=lane - middle, depth=floor)
        for clip, lane in zip(clips, lanes, strict=True)
    ]
