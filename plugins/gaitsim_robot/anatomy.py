"""Legs, feet, sides and the standing pose of a robot."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Leg:
    """A leg.

    Attributes:
        name: L1, R1, L2 … front to back; M1 … in the middle plane.
        side: of the body.
        joints: names of its driven joints, from the hip to the foot.
        foot: name of the body that touches the ground.
        point: where it does in the standing pose, in the frame of that body, (3,) m.
    """

    name: str
    side: Literal["left", "right", "middle"]
    joints: tuple[str, ...]
    foot: str
    point: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Anatomy:
    """What is found in a robot.

    Attributes:
        legs: L1, R1, L2 …
        held: names of driven joints that belong to no leg; their servos keep the standing pose.
        stance: the standing pose of the whole robot on the ground z = 0, (nq,).
        mass: kg.
        length: of the trunk along x, m.
    """

    legs: tuple[Leg, ...]
    held: tuple[str, ...]
    stance: Floats
    mass: float
    length: float

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of all joints of legs, leg by leg."""
        return tuple(joint for leg in self.legs for joint in leg.joints)


def find_anatomy(model: Any) -> Anatomy:
    """Find legs, feet and the standing pose of a compiled robot's text."""
    raise NotImplementedError
