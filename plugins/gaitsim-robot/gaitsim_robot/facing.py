"""The direction of a robot's nose, which the names of its legs or its shape indicate."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim_robot.anatomy import Facing, Side, name_legs
from gaitsim_robot.limbs import Limb

ALIKE = 0.2  # largest difference between mirrored legs, as a share of a leg's length
LONGER = 1.3  # ratio of the extents along y and x above which a robot faces along y
HEADINGS: Mapping[Facing, tuple[int, int]] = {
    "+x": (1, 0),
    "-x": (-1, 0),
    "+y": (0, 1),
    "-y": (0, -1),
}
"""Direction of the nose for each value of `facing`: components along x and y."""

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_FRONT = {"front": 1, "fore": 1, "rear": -1, "hind": -1, "back": -1}
_LEFT = {"left": 1, "right": -1}
_PAIRS = {  # front or rear, and left or right
    **dict.fromkeys(("fl", "lf"), (1, 1)),
    **dict.fromkeys(("fr", "rf"), (1, -1)),
    **dict.fromkeys(("rl", "lr", "hl", "lh", "bl", "lb"), (-1, 1)),
    **dict.fromkeys(("rr", "hr", "rh", "br", "rb"), (-1, -1)),
}
_LETTER = {"l": 1, "r": -1}


def facings_of_names(model: Any, limbs: Sequence[Limb]) -> list[Facing]:
    """Return the directions of the nose that no name of a leg contradicts.

    Returns:
        The directions; [] unless the names distinguish front from rear and left from right.
    """
    named = [_named_place(model, limb) for limb in limbs]
    if not all(_distinguished(named)):
        return []
    seen = np.array([[_sign(limb, limbs, axis) for axis in (0, 1)] for limb in limbs])
    turned = {  # to the front and to the left
        facing: seen @ np.array([[x, -y], [y, x]]) for facing, (x, y) in HEADINGS.items()
    }
    return [facing for facing, place in turned.items() if (place * named >= 0).all()]


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
    remedy = (
        f"set 'organism.facing' to {fitting[0]}, which fits all names"
        if len(fitting) == 1
        else "set 'organism.facing' to the direction of the nose in the file (+x, -x, +y or -y), "
        "or rename the joints"
    )
    named = [_named_place(model, limb) for limb in limbs]
    told = _distinguished(named)
    for name, limb, said in zip(name_legs(sides), limbs, named, strict=True):
        place = _sign(limb, limbs, 0), _sign(limb, limbs, 1)
        if any(told[axis] and said[axis] * place[axis] < 0 for axis in (0, 1)):
            return (
                f"joint {model.joint(limb.joints[0]).name!r} belongs to leg {name}, "
                f"{_describe_place(place)}, although its name says {_describe_place(said)}; "
                f"{remedy}",
            )
    return ()


def _distinguished(named: Sequence[tuple[int, int]]) -> list[bool]:
    """Return whether names distinguish front from rear, and left from right."""
    return [set(column) >= {1, -1} for column in zip(*named, strict=True)]


def facing_of_shape(limbs: Sequence[Limb], default: int) -> Facing:
    """Return the direction of the nose that the shape of the robot indicates.

    A robot with two legs faces in the direction of its feet. A robot with more legs that faces
    along the y axis faces in the direction `default` · y.
    """
    along_y = _faces_along_y(limbs)
    axis, sign = (1, default) if along_y else (0, 1)
    for joint, least in ((-1, 0.02), (0, 0.08)) if len(limbs) == 2 else ():
        toes = [(one.chain.tip - one.chain.anchors[joint])[axis] / one.length for one in limbs]
        if abs(np.mean(toes)) > least:  # measured from the ankle, or else from the hip
            sign = int(np.sign(np.mean(toes)))
            break
    heading = (0, sign) if along_y else (sign, 0)
    return next(facing for facing, other in HEADINGS.items() if other == heading)


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
        if abs(place) > 0.05 * limb.length:
            return 1 if place > 0 else -1
    return 0


def _describe_place(place: tuple[int, int]) -> str:
    """Return 'front left' for (1, 1), 'left' for (0, 1), and 'middle' for (0, 0)."""
    front, left = place
    words = {1: "front", -1: "rear"}.get(front), {1: "left", -1: "right"}.get(left)
    return " ".join(filter(None, words)) or "middle"


def _named_place(model: Any, limb: Limb) -> tuple[int, int]:
    """Return where the names of a leg's joints and links say that it is, such as 'FR_hip'.

    Returns:
        1 for front, -1 for rear, 0 if the names tell neither or disagree; and 1 for left, -1 for
        right, 0 likewise.
    """
    names = [model.joint(joint).name for joint in limb.joints]
    names += [model.body(body).name for body in limb.parts]
    front, left = (sum(set(column)) for column in zip(*map(_place, names), strict=True))
    return front, left


def _place(name: str) -> tuple[int, int]:
    words = [word.lower() for word in _WORD.findall(name)]
    pair = next((_PAIRS[word] for word in words if word in _PAIRS), (0, 0))
    front = next((_FRONT[word] for word in words if word in _FRONT), pair[0])
    left = next((_LEFT[word] for word in words if word in _LEFT), pair[1])
    letter = next((_LETTER[word] for word in (*words[:1], *words[-1:]) if word in _LETTER), 0)
    return front, left or letter
