"""The trunk and its heading, the travel of the body and its static stability."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.gait.feet import Contacts, Floats, half_way, steps

_FRAMES = 30  # number of frames in which distances are compared
_SEGMENTS = 200  # number of segments compared, for bodies with thousands of them
_RIGID = 1e-4  # tolerance for distances within the trunk, as a share of the body's size

_SEEN = 0.3  # least share of the shape that is visible from above in a body with a heading


def size(skeleton: Skeleton) -> float:
    """Return the longest diagonal of the box around the body over time, metres."""
    points = skeleton.segments.reshape(len(skeleton.segments), -1, 3).astype(np.float64)
    return float(np.linalg.norm(np.ptp(points, axis=1), axis=-1).max(initial=0.0))


@lru_cache(4)  # it takes 3 ms, and several measures of a motion and its picture need it
def trunk(skeleton: Skeleton) -> Floats:
    """Return the points of the trunk over time, (frames, points, 3), metres.

    For each segment, the ends of all segments that keep a constant distance from both of its ends
    form a rigid group. The trunk is the group with the most distinct points; ties go to the group
    of the first segment.
    """
    every = -(-skeleton.segments.shape[1] // _SEGMENTS)
    segments = skeleton.segments[:, ::every].astype(np.float64)
    points = segments.reshape(len(segments), -1, 3)
    compared = np.unique(np.linspace(0, len(points) - 1, _FRAMES).astype(int))
    least = np.full((points.shape[1],) * 2, np.inf)
    most = np.zeros_like(least)
    for frame in compared:
        distance = np.linalg.norm(points[frame, :, None] - points[frame], axis=-1)
        least, most = np.minimum(least, distance), np.maximum(most, distance)
    rigid = most - least <= _RIGID * size(skeleton)
    places = np.unique(points[0].round(9), axis=0, return_inverse=True)[1].ravel()
    groups = [rigid[2 * segment] & rigid[2 * segment + 1] for segment in range(segments.shape[1])]
    best: NDArray[np.bool_] = max(groups, key=lambda group: len(np.unique(places[group])))
    if not best.any():  # no segment has a constant length
        best[:2] = True
    found: Floats = points[:, best]
    found.flags.writeable = False
    return found


def heading(body: Floats) -> Floats | None:
    """Return the turn of a rigid group of points to the left since the start, seen from above.

    Args:
        body: positions of the points, (frames, points, 3), metres.

    Returns:
        The turn, (frames,), radians, not wrapped; None if the points lie almost vertically above
        one another in any frame, as a body that tumbles has no heading.
    """
    flat = body[..., :2] - body[..., :2].mean(axis=1, keepdims=True)
    if np.abs(flat).max(initial=0.0) < 1e-9:
        return None
    x, y = flat[0].T
    along = flat[..., 0] @ x + flat[..., 1] @ y
    across = flat[..., 1] @ x - flat[..., 0] @ y
    if np.hypot(along, across).min() < _SEEN * along[0]:
        return None
    return np.asarray(np.unwrap(np.arctan2(across, along)))


GRAVITY = 9.81  # m/s²
NONE: Mapping[str, float] = MappingProxyType({})
_LYING = 0.05  # height of a centre that lies on the ground, as a share of the body's size


@dataclass(frozen=True)
class Travel:
    """The travel of a gait in SI units; None for a value that is not defined.

    Attributes:
        seconds: duration from the first frame to the last, or to a fall.
        forward, lateral, climb: displacement along x, to the left, and up, over the whole motion.
        path: length of the path of the centre, seen from above.
        speed: displacement, seen from above, over time.
        straightness: displacement over path, the straightness index (Batschelet 1981, Circular
            Statistics in Biology); 1 is a straight line.
        deviation: largest lateral deviation from the starting line.
        yaw: turn to the left at the end, radians.
        yaw_range: angle between the headings furthest to the left and to the right, radians.
        height: mean height of the centre above the ground, z = 0.
        froude: speed² / (gravity × height) (Alexander 1989, Physiological Reviews 69:1199,
            with the centre instead of the hip); None if the centre lies on the ground.
        joint_travel: sum of the turns of all joints per metre of displacement, rad/m. It does not
            measure energy, because it includes neither load nor torque.
        cost_of_transport: work over weight times displacement, as measured by the body.
        lasted: time before a fall, or of the whole motion, as measured by the body.
    """

    seconds: float
    forward: float
    lateral: float
    climb: float
    path: float
    speed: float
    straightness: float | None
    deviation: float
    yaw: float | None
    yaw_range: float | None
    height: float
    froude: float | None
    joint_travel: float | None
    cost_of_transport: float | None
    lasted: float | None


@dataclass(frozen=True)
class Slip:
    """The sliding of feet on the ground.

    Attributes:
        distance: slide of the feet that stand, mean over feet and sum over time, metres.
        ratio: `distance` over the length of the path; None without a path. Like the longitudinal
            slip of rolling wheels, it is 0 for feet that stay in place.
        share: `distance` over the movement of the standing feet relative to the body: 0 if all of
            this movement carried the body, 1 if none did; None if the feet did not move.
    """

    distance: float
    ratio: float | None
    share: float | None


def travel_of(
    skeleton: Skeleton, joint_angles: Array | None, measured: Mapping[str, float] = NONE
) -> Travel:
    """Return the travel of a skeleton and of its joint angles, (frames, joints), if it has any.

    Quantities that the body measured, in SI units by name, replace values from the skeleton.
    """
    path = skeleton.path.astype(np.float64)
    moved = path[-1] - path[0]
    straight = float(np.hypot(moved[0], moved[1]))
    length = float(steps(path).sum())
    lasted = measured.get("lasted")
    seconds = (len(path) - 1) / skeleton.frame_rate if lasted is None else lasted
    speed = straight / seconds if seconds else 0.0
    turned = heading(trunk(skeleton))
    height = float(path[:, 2].mean())
    return Travel(
        seconds=seconds,
        forward=measured.get("forward", float(moved[0])),
        lateral=measured.get("lateral", float(moved[1])),
        climb=measured.get("climb", float(moved[2])),
        path=length,
        speed=speed,
        straightness=straight / length if length else None,
        deviation=float(np.abs(path[:, 1] - path[0, 1]).max()),
        yaw=measured.get("yaw", None if turned is None else float(turned[-1])),
        yaw_range=None if turned is None else float(np.ptp(turned)),
        height=height,
        froude=speed**2 / (GRAVITY * height) if height > _LYING * size(skeleton) else None,
        joint_travel=_joint_travel(joint_angles, straight),
        cost_of_transport=measured.get("cost of transport"),
        lasted=lasted,
    )


def _joint_travel(angles: Array | None, metres: float) -> float | None:
    if angles is None or not metres:
        return None
    return float(np.abs(np.diff(angles.astype(np.float64), axis=0)).sum()) / metres


def slip_of(
    contacts: Floats, touching: Contacts, path: Floats, relative: Floats, ratio: float | None = None
) -> Slip:
    """Measure the sliding of feet on the ground.

    Args:
        contacts: positions of the feet in the world, (frames, feet, 3), metres.
        touching: whether each foot is on the ground, (frames, feet).
        path: path of the body, (frames, 3), metres.
        relative: positions of the feet in the frame of the body, (frames, feet, 3), metres.
        ratio: ratio of slide to path as measured by the body, which accounts for rolling feet and
            the plane of the ground; None computes it from the contacts.
    """
    down = touching[:-1]
    slid = mean_of(steps(contacts), down)
    length, pushed = float(steps(path).sum()), float(mean_of(steps(relative), down).sum())
    distance = float(slid.sum()) if ratio is None else ratio * length
    return Slip(
        distance, distance / length if length else None, distance / pushed if pushed else None
    )


def mean_of(values: Floats, chosen: Contacts) -> Floats:
    """Return the mean over the chosen feet, (frames, feet) -> (frames,); 0 if none is chosen."""
    count = np.maximum(chosen.sum(axis=1), 1)
    return np.asarray((values * chosen).sum(axis=1) / count)


def lying(skeleton: Skeleton) -> float:
    """Return the share of time that the trunk is on the ground, z = 0 ± 1 % of the body's size."""
    lowest = half_way(trunk(skeleton)[..., 2]).min(axis=1)
    return float(np.mean(lowest < 0.01 * size(skeleton)))


def frames_in(lasted: float, frame_rate: float) -> int:
    """Return the number of frames before a fall at `lasted`, s; at least 2."""
    return max(round(lasted * frame_rate) + 1, 2)


_LINE = 1e-6  # tolerance for points in a vertical plane, m


def stability_margin(skeleton: Skeleton) -> Floats:
    """Return the static stability margin over time, (frames,) float64, metres.

    The margin is the distance of the centre, seen from above, from the nearest edge of the support
    polygon, which is the convex hull of the feet on the ground (McGhee & Frank 1968, Mathematical
    Biosciences 3:331). It is negative if the centre is outside the polygon, and with one or two
    feet on the ground, which span no polygon. Without a foot on the ground, it is −inf. It is
    computed half-way from each frame to the next.

    A body whose centre and feet all move in one vertical plane along x, such as a planar walker,
    cannot tip sideways: its support extends from its hindmost to its foremost foot.
    """
    if skeleton.contacts is None or skeleton.touching is None:
        raise GaitsimError(
            "a body without feet has no stability margin",
            allowed="a skeleton with contacts and touching",
        )
    feet = half_way(skeleton.contacts)[..., :2]
    centre = half_way(skeleton.path)[:, :2]
    sideways = np.concatenate([feet[..., 1].ravel(), centre[:, 1]])
    planar = np.ptp(sideways) < _LINE
    margin = np.full(len(feet), -np.inf)
    for frame, (places, down) in enumerate(zip(feet, skeleton.touching, strict=True)):
        standing = places[down]
        if not len(standing):
            continue
        if planar:
            x = centre[frame, 0]
            margin[frame] = min(x - standing[:, 0].min(), standing[:, 0].max() - x)
        else:
            margin[frame] = distance_inside(convex_hull(standing), centre[frame])
    return margin


def distance_inside(corners: Floats, point: Floats) -> float:
    """Return the distance of a point to the edge of a convex polygon, negative outside.

    Args:
        corners: corners of the polygon, (corners, 2), counter-clockwise; two corners are a line and
            one is a point, which have no inside.
        point: position of the point, (2,).
    """
    along = np.roll(corners, -1, axis=0) - corners
    away = point - corners
    squares = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip((away * along).sum(axis=1) / squares, 0, 1)
    nearest = float(np.hypot(*(away - share[:, None] * along).T).min())
    left = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    return nearest if len(corners) > 2 and (left >= 0).all() else 0.0 - nearest


def convex_hull(points: Floats) -> Floats:
    """Return the corners of the convex hull, counter-clockwise, (corners, 2) (Andrew 1979)."""
    ordered = np.unique(points, axis=0).tolist()
    if len(ordered) < 3:
        return np.array(ordered)
    halves = []
    for sweep in (ordered, ordered[::-1]):
        half: list[list[float]] = []
        for point in sweep:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0:
                half.pop()
            half.append(point)
        halves += half[:-1]
    return np.array(halves)


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    """Return twice the area of a triangle, positive if a, b, c turn left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
