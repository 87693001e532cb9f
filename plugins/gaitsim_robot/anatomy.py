"""Legs, feet, sides and the standing pose of a robot."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Side = Literal["left", "right", "middle"]
Facing = Literal["auto", "+x", "-x", "+y", "-y"]
"""Direction of the nose in a robot's file; 'auto' finds it."""


@dataclass(frozen=True)
class Leg:
    """A leg.

    Attributes:
        name: name of the leg: L1, R1, L2 … from front to back, M1 … in the middle plane.
        side: side of the trunk.
        joints: names of its driven joints, from the hip to the foot.
        foot: name of the body that touches the ground.
        point: contact point in the standing pose, in the frame of the foot, (3,) m.
        length: length from the hip along the joints to the foot, m.
        sole: extents of a level sole along x and y, m; 0 for a point foot.
    """

    name: str
    side: Side
    joints: tuple[str, ...]
    foot: str
    point: tuple[float, float, float]
    length: float = 0.0
    sole: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Anatomy:
    """The legs and the standing pose of a robot.

    Attributes:
        legs: the legs L1, R1, L2 …
        held: names of joints outside the legs; their servos hold the standing pose.
        stance: standing pose of the whole robot on the ground z = 0, (nq,), facing along x. The
            trunk's quaternion is not the identity if the robot does not face along x in its file,
            or if y points up.
        mass: mass of the robot, kg.
        length: body length, the unit of scores, m: the length of the trunk, and for two-legged
            robots at least that of a leg.
        trunk: length of the trunk along x, m.
        notes: remarks for the user, one sentence each.
        warnings: likely mistakes in the file, each with a remedy.
    """

    legs: tuple[Leg, ...]
    held: tuple[str, ...]
    stance: Floats
    mass: float
    length: float
    trunk: float
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of all joints of legs, leg by leg."""
        return tuple(joint for leg in self.legs for joint in leg.joints)


def name_legs(sides: Sequence[Side]) -> list[str]:
    """Return L1, R1, M1 … for legs in order from front to back."""
    letters = {"left": "L", "right": "R", "middle": "M"}
    names = []
    for index, side in enumerate(sides):
        number = 1 + sum(other == side for other in sides[:index])
        names.append(f"{letters[side]}{number}")
    return names


_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_FRONT = {"front": 1, "fore": 1, "rear": -1, "hind": -1, "back": -1}
_LEFT = {"left": 1, "right": -1}
_PAIRS = {
    **dict.fromkeys(("fl", "lf"), (1, 1)),
    **dict.fromkeys(("fr", "rf"), (1, -1)),
    **dict.fromkeys(("rl", "lr", "hl", "lh", "bl", "lb"), (-1, 1)),
    **dict.fromkeys(("rr", "hr", "rh", "br", "rb"), (-1, -1)),
}
_LETTER = {"l": 1, "r": -1}


def named_place(names: Iterable[str]) -> tuple[int, int]:
    """Return where the names of a leg's joints and links say that it is, such as 'FR_hip'.

    Returns:
        1 for front, -1 for rear, 0 if the names do not say so or disagree; and 1 for left, -1 for
        right, 0 likewise.
    """
    places = [_place(name) for name in names]
    fronts, lefts = ({one for one in found if one} for found in zip(*places, strict=True))
    return (
        fronts.pop() if len(fronts) == 1 else 0,
        lefts.pop() if len(lefts) == 1 else 0,
    )


def _place(name: str) -> tuple[int, int]:
    words = [word.lower() for word in _WORD.findall(name)]
    pair = next((_PAIRS[word] for word in words if word in _PAIRS), (0, 0))
    front = next((_FRONT[word] for word in words if word in _FRONT), pair[0])
    left = next((_LEFT[word] for word in words if word in _LEFT), pair[1])
    letter = next((_LETTER[word] for word in (*words[:1], *words[-1:]) if word in _LETTER), 0)
    return front, left or letter
