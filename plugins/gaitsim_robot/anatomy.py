"""Legs, feet, sides and the standing pose of a robot."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, unknown

Floats = NDArray[np.float64]
Side = Literal["left", "right", "middle"]


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
            trunk's quaternion is not the identity if the robot faces along y in its file, or if
            y points up.
        mass: mass of the robot, kg.
        length: length of the trunk along x, m; at least the distance between the front and rear
            hips, and for two-legged robots at least the length of a leg.
        notes: remarks for the user, one sentence each.
    """

    legs: tuple[Leg, ...]
    held: tuple[str, ...]
    stance: Floats
    mass: float
    length: float
    notes: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of all joints of legs, leg by leg."""
        return tuple(joint for leg in self.legs for joint in leg.joints)


def find_anatomy(
    model: Any, feet: Sequence[str] = (), stance: Mapping[str, float] | None = None
) -> Anatomy:
    """Find the legs, feet and standing pose of a robot.

    The legs are the limbs that reach lowest. The standing pose is the keyframe `stand`, or the
    pose at zero if the robot stands in it. Otherwise it is a pose with bent knees and the feet
    below the hips or, for sprawling legs, out to the sides.

    Args:
        model: `mujoco.MjModel` of the robot's text.
        feet: names of the links at the ends of the legs; () finds them.
        stance: angles of joints in the standing pose by name, rad. Other joints have the angles of
            the keyframe, or zero. None searches for a pose.
    """
    from gaitsim_robot.finding import Finder

    if model.nbody < 2 or model.njnt < 2:
        raise GaitsimError(
            "the robot has no joints",
            allowed="a trunk with at least two legs of hinge joints",
        )
    _check_names(model, feet, stance or {})
    return Finder(model, feet, stance).find()


def name_legs(sides: Sequence[Side]) -> list[str]:
    """Return L1, R1, M1 … for legs in order from front to back."""
    letters = {"left": "L", "right": "R", "middle": "M"}
    names = []
    for index, side in enumerate(sides):
        number = 1 + sum(other == side for other in sides[:index])
        names.append(f"{letters[side]}{number}")
    return names


def _check_names(model: Any, feet: Sequence[str], stance: Mapping[str, float]) -> None:
    bodies = [model.body(index).name for index in range(2, model.nbody)]
    for name in feet:
        if name not in bodies:
            raise unknown("link", name, bodies, key="feet")
    if len(set(feet)) < len(feet):
        raise GaitsimError(
            f"duplicate foot: {', '.join(feet)}", key="feet", allowed="each link at most once"
        )
    joints = [model.joint(index).name for index in range(1, model.njnt)]
    for name, angle in stance.items():
        if name not in joints:
            raise unknown("joint", name, joints, key="stance")
        joint = model.joint(name)
        lower, upper = model.jnt_range[joint.id]
        if model.jnt_limited[joint.id] and not lower <= angle <= upper:
            raise GaitsimError(
                f"the stance angle {math.degrees(angle):.4g}° of joint {name!r} is outside the "
                "joint's limits",
                key="stance",
                allowed=f"{math.degrees(lower):.4g}° to {math.degrees(upper):.4g}°",
            )
