"""The direction of a robot's nose, which the names of its legs or its shape indicate."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim_robot.anatomy import Facing, Floats, Side, name_legs
from gaitsim_robot.limbs import Limb
from gaitsim_robot.names import places, rows

CLOSE = 0.05  # share of a leg's length; closer legs have the same place along an axis
ALIKE = 0.2  # largest difference between mirrored legs, as a share of a leg's length
LONGER = 1.3  # ratio of the extents along y and x above which a robot faces along y
HEADINGS: Mapping[Facing, tuple[int, int]] = {
    "+x": (1, 0),
    "-x": (-1, 0),
    "+y": (0, 1),
    "-y": (0, -1),
}
"""Direction of the nose for each value of `facing`: components along x and y."""


def facings_of_names(model: Any, limbs: Sequence[Limb], *, numbers: bool = True) -> list[Facing]:
    """Return the directions of the nose that the names of legs confirm and no name contradicts.

    Args:
        model: MuJoCo's model.
        limbs: the legs.
        numbers: whether the numbers of legs also count, from front to rear.
    """
    told = _told(model, limbs, numbers)
    return [facing for facing in HEADINGS if _fits(limbs, told, facing)]


def misnamed(
    model: Any, limbs: Sequence[Limb], sides: Sequence[Side], fitting: Sequence[Facing]
) -> tuple[str, ...]:
    """Return a warning if the names of legs contradict their places, or ().

    Args:
        model: MuJoCo's model.
        limbs: the legs of a robot that faces x, from front to back.
        sides: side of each leg.
        fitting: directions of the nose in the file that would contradict no name.
    """
    told = _told(model, limbs)
    contradicted = _agreement(limbs, told, "+x").min(axis=2)[:-1] < 0
    if not contradicted.any():
        return ()
    # A leg on the wrong side of the middle of all legs, or else one in a wrong order.
    wrong = contradicted[:, -1] if contradicted[:, -1].any() else contradicted.any(axis=1)
    index = int(np.argmax(wrong))
    limb = limbs[index]
    remedy = (
        f"set 'organism.facing' to {fitting[0]}, which fits all names"
        if len(fitting) == 1
        else "set 'organism.facing' to the direction of the nose in the file (+x, -x, +y or -y), "
        "or rename the joints"
    )
    return (
        f"joint {model.joint(limb.joints[0]).name!r} belongs to leg {name_legs(sides)[index]}, "
        f"{_describe_place(_sign(limb, limbs, 0), _sign(limb, limbs, 1))}, although its name says "
        f"{_describe_place(*np.nan_to_num(np.sign(told[index])))}; {remedy}",
    )


def names_of(model: Any, limb: Limb) -> list[str]:
    """Return the names of a limb's joints and links."""
    joints = [model.joint(joint).name for joint in limb.joints]
    return joints + [model.body(body).name for body in limb.parts]


def _told(model: Any, limbs: Sequence[Limb], numbers: bool = True) -> Floats:
    """Return the places that names tell, (limbs, 2), as `places` does, or numbers to the front."""
    names = [names_of(model, limb) for limb in limbs]
    told = places(names)
    if numbers and np.isnan(told[:, 0]).all():
        numbered = np.column_stack([rows(names, told[:, 1]), told[:, 1]])
        # Numbers that go around the robot do not count from front to rear.
        if any(_fits(limbs, numbered, facing, axes=1) for facing in HEADINGS):
            return numbered
    return told


def _fits(limbs: Sequence[Limb], told: Floats, facing: Facing, axes: int = 2) -> bool:
    """Return whether a pair of legs confirms a direction and none contradicts it."""
    agreement = _agreement(limbs, told, facing)[:, :, :axes]
    return bool((agreement >= 0).all() and (agreement > 0).any())


def _agreement(limbs: Sequence[Limb], told: Floats, facing: Facing) -> Floats:
    """Return whether pairs of legs are in the order that their names tell if the robot faces there.

    Returns:
        1 for pairs in this order, -1 in the opposite one, and 0 otherwise, from front to rear and
        from left to right, (limbs + 1, limbs + 1, 2). The last is the middle of all legs.
    """
    x, y = HEADINGS[facing]
    ends = np.array([[limb.hip[:2], limb.chain.tip[:2]] for limb in limbs])
    ends = np.concatenate([ends, ends.mean(axis=0, keepdims=True)]) @ [[x, -y], [y, x]]
    told = np.vstack([told, [0, 0]])
    apart = ends[:, None] - ends
    apart[np.abs(apart) < CLOSE * np.mean([limb.length for limb in limbs])] = 0
    hips, tips = apart[:, :, 0], apart[:, :, 1]
    said = np.nan_to_num(np.sign(told[:, None] - told))
    said[told[:, None, 1] * told[:, 1] < 0, 0] = 0  # legs on both sides may be staggered
    agreement: Floats = np.sign(np.where(hips, hips, tips)) * said
    return agreement


def facing_of_shape(limbs: Sequence[Limb], default: int) -> Facing:
    """Return the direction of the nose that the shape of the robot indicates.

    A robot with two legs faces in the direction of its feet. A robot with more legs that faces
    along the y axis faces in the direction `default` · y.
    """
    along_y = _faces_along_y(limbs)
    axis, sign = (1, default) if along_y else (0, 1)
    if len(limbs) == 2:
        sign = toes(limbs, axis) or sign
    heading = (0, sign) if along_y else (sign, 0)
    return next(facing for facing, other in HEADINGS.items() if other == heading)


def toes(limbs: Sequence[Limb], axis: int) -> int:
    """Return in which direction along an axis feet point: 1, -1, or 0 if neither is clear."""
    for joint, least in ((-1, 0.02), (0, 0.08)):  # measured from the ankle, or else from the hip
        ahead = [(one.chain.tip - one.chain.anchors[joint])[axis] / one.length for one in limbs]
        if abs(np.mean(ahead)) > least:
            return int(np.sign(np.mean(ahead)))
    return 0


def _faces_along_y(limbs: Sequence[Limb]) -> bool:
    """Return whether the robot faces along y, so that its legs form pairs along x."""
    if len(limbs) == 2:
        # Knees turn about the lateral axis, also in a planar robot whose legs are in line.
        knees = np.abs([limb.chain.axes[limb.knee % len(limb.joints)] for limb in limbs])
        return bool(knees[:, 0].mean() > knees[:, 1].mean())
    along_x, along_y = (count_mirrored(limbs, axis) for axis in (0, 1))
    if along_x != along_y:
        return along_x > along_y
    spread = np.ptp([limb.hip for limb in limbs], axis=0)
    return bool(spread[1] > LONGER * spread[0])


def count_mirrored(limbs: Sequence[Limb], axis: int) -> int:
    """Return the number of limbs that have a mirror image along an axis among the others."""
    if not limbs:
        return 0
    size = float(np.mean([limb.length for limb in limbs]))
    ends = np.array([[limb.hip, limb.chain.tip] for limb in limbs])
    middle = ends[:, :, axis].mean()
    images = ends.copy()
    images[:, :, axis] = 2 * middle - ends[:, :, axis]
    distance = np.linalg.norm(images[:, None] - ends, axis=3).max(axis=2)
    nearest = distance.argmin(axis=1)
    others = nearest != np.arange(len(limbs))
    return int((others & (distance.min(axis=1) < ALIKE * size)).sum())


def side_of(limb: Limb, limbs: Sequence[Limb]) -> Side:
    """Return the side of a leg of a robot that faces x."""
    sides: dict[int, Side] = {1: "left", -1: "right", 0: "middle"}
    return sides[_sign(limb, limbs, 1)]


def _sign(limb: Limb, limbs: Sequence[Limb], axis: int) -> int:
    """Return on which side of the middle of all legs a leg is along an axis; 0 in the middle."""
    middle = float(np.mean([one.hip[axis] for one in limbs]))
    for place in (limb.hip[axis] - middle, limb.chain.tip[axis] - middle):
        if abs(place) > CLOSE * limb.length:
            return 1 if place > 0 else -1
    return 0


def _describe_place(front: float, left: float) -> str:
    """Return 'front left' for 1 and 1, 'left' for 0 and 1, and 'middle' for 0 and 0."""
    row, side = ("middle", "front", "rear")[int(front)], ("middle", "left", "right")[int(left)]
    return " ".join(word for word in (row, side) if word != "middle") or "middle"
