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
        name: L1, R1, L2 … front to back; M1 … in the middle plane.
        side: of the body.
        joints: names of its driven joints, from the hip to the foot.
        foot: name of the body that touches the ground.
        point: where it does in the standing pose, in the frame of that body, (3,) m.
        length: from the hip along the joints to the foot, m.
        sole: extent of a level sole along x and y, m; 0 for a foot that is a point.
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
        legs: L1, R1, L2 …
        held: names of joints that belong to no leg; their servos keep the standing pose.
        stance: the standing pose of the whole robot on the ground z = 0, (nq,), in which it
            faces along x. The quaternion of the trunk is not the identity where the file has
            the robot face along y, or y point up.
        mass: kg.
        length: of the trunk along x, at least from the front hips to the rear ones; of two-legged
            robots at least that of a leg, m.
        notes: findings that the user should know, one sentence each.
    """

    legs: tuple[Leg, ...]
    held: tuple[str, ...]
    stance: Floats
    mass: float
    length: float
    notes: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of all joints of legs, leg by leg."""
        return tuple(joint for leg in self.legs for joint in leg.joints)


def find_anatomy(
    model: Any, feet: Sequence[str] = (), stance: Mapping[str, float] | None = None
) -> Anatomy:
    """Find legs, feet and the standing pose of a compiled robot's text.

    The legs are the limbs that reach lowest. The standing pose is the keyframe `stand`, or the
    pose at zero if the robot stands in it, or else a pose with the feet below the hips and bent
    knees, or, for legs that sprawl, with the feet out at the sides.

    Args:
        model: `mujoco.MjModel` of the robot's text.
        feet: names of the bodies at the ends of the legs; () finds them.
        stance: angles of joints in the standing pose by name, rad. Other joints are as in the
            keyframe, or at zero. None finds the pose.

    Raises:
        GaitsimError: no legs, no standing pose, or names of bodies or joints that are not there.
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
            raise unknown("body", name, bodies, key="feet")
    if len(set(feet)) < len(feet):
        raise GaitsimError(
            f"the same foot more than once: {', '.join(feet)}", key="feet", allowed="each body once"
        )
    joints = [model.joint(index).name for index in range(1, model.njnt)]
    for name, angle in stance.items():
        if name not in joints:
            raise unknown("joint", name, joints, key="stance")
        joint = model.joint(name)
        lower, upper = model.jnt_range[joint.id]
        if model.jnt_limited[joint.id] and not lower <= angle <= upper:
            raise GaitsimError(
                f"the angle {math.degrees(angle):.4g}° of joint {name!r} is outside its limits",
                key="stance",
                allowed=f"{math.degrees(lower):.4g}° to {math.degrees(upper):.4g}°",
            )
