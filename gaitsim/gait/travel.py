"""Travel of a body: displacement, speed, straightness, slip and joint travel."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from gaitsim.contracts import Array, Skeleton
from gaitsim.gait.contact import Contacts
from gaitsim.gait.intervals import Floats, half_way, steps
from gaitsim.gait.trunk import heading, size, trunk

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
    contacts: Floats,
    touching: Contacts,
    path: Floats,
    relative: Floats,
    ratio: float | None = None,
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
