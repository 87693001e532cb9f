"""Legs, feet, sides and the standing pose of a robot."""

from collections.abc import Sequence
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
        held: names of driven joints outside the legs; their servos hold the standing pose.
        passive: names of joints without a motor, in legs and outside.
        swing: names of driven joints outside the legs that swing with the rhythm.
        wheels: names of driven joints of wheels at the ends of legs.
        rolling: names of those that roll; others hold their angles.
        stance: standing pose of the whole robot on the ground z = 0, (nq,), facing along x. The
            trunk's quaternion is not the identity if the robot does not face along x in its file,
            or if y points up.
        mass: mass of the robot, kg.
        length: body length, the unit of scores, m: the length of the trunk, and for two-legged
            robots at least that of a leg.
        trunk: length of the trunk along x, m.
        notes: remarks for the user, one sentence each.
        warnings: likely mistakes in the file, each with a remedy.
        doubt: question whether limbs that were not taken for legs are legs, or ''.
        guessed_facing: direction of the nose if only the shape of the robot indicates it; else ''.
        searched: whether the standing pose was searched for.
        crawls: whether the body may lie, tilt, and touch the ground with its trunk, so that only an
            unstable simulation ends a rollout.
    """

    legs: tuple[Leg, ...]
    held: tuple[str, ...]
    stance: Floats
    mass: float
    length: float
    trunk: float
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    passive: tuple[str, ...] = ()
    swing: tuple[str, ...] = ()
    wheels: tuple[str, ...] = ()
    rolling: tuple[str, ...] = ()
    doubt: str = ""
    guessed_facing: str = ""
    searched: bool = False
    crawls: bool = False

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that gaits move: legs, leg by leg, then `swing`, then `rolling`."""
        legs = (joint for leg in self.legs for joint in leg.joints)
        return (*legs, *self.swing, *self.rolling)


def name_legs(sides: Sequence[Side]) -> list[str]:
    """Return L1, R1, M1 … for legs in order from front to back."""
    letters = {"left": "L", "right": "R", "middle": "M"}
    names = []
    for index, side in enumerate(sides):
        number = 1 + sum(other == side for other in sides[:index])
        names.append(f"{letters[side]}{number}")
    return names
