"""The spider's body: geometry, masses, dimensions and limits, in SI units and radians.

In the body's frame, x points forward, y left and z up; the origin is the centre of the body, at the
height of the hips. The order of the legs is L1 L2 L3 L4 R1 R2 R3 R4, front to back.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitsim.plugin import Array, Dimension
from gaitsim.plugin.toolkit import scalar_sin as sin

LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
SEGMENTS = ("coxa", "femur", "tibia")
SIDES = (LEGS[:4], LEGS[4:])
LEG_JOINTS = {leg: tuple(f"{leg} {segment}" for segment in SEGMENTS) for leg in LEGS}
JOINTS = tuple(joint for joints in LEG_JOINTS.values() for joint in joints)

FRAMES = 300
FRAME_RATE = 30.0  # Hz

BODY_LENGTH, BODY_WIDTH = 0.20, 0.14  # m
BODY_MASS = 0.8  # kg
_CORNERS = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
OUTLINE_NAMES = ("front", "right side", "back", "left side")
OUTLINE = np.zeros((4, 2, 3))  # m, ends of each edge
OUTLINE[:, 0, :2] = np.multiply(_CORNERS, [BODY_LENGTH / 2, BODY_WIDTH / 2])
OUTLINE[:, 1] = np.roll(OUTLINE[:, 0], -1, axis=0)

HIP_X = np.array([0.075, 0.025, -0.025, -0.075] * 2, dtype=np.float32)  # m
HIP_Y = 0.07  # m, towards the leg's side
SIDE = np.array([1.0] * 4 + [-1.0] * 4, dtype=np.float32)  # left +1, right −1
# Direction of each leg at rest, from sideways towards the front.
AZIMUTH = np.radians([45.0, 15.0, -15.0, -45.0] * 2).astype(np.float32)

COXA, FEMUR, TIBIA = 0.03, 0.08, 0.12  # m
COXA_MASS, FEMUR_MASS, TIBIA_MASS = 0.01, 0.02, 0.02  # kg

# Pitch at rest, from the horizontal. Joint angles are offsets from this pose.
FEMUR_PITCH = math.radians(30.0)
TIBIA_PITCH = math.radians(-80.0)
# A foot is the centre of a small ball at the tip of the tibia, so the body's centre is
# 0.0782 + 0.008 = 0.0862 m above the ground.
FOOT_RADIUS = 0.008  # m
STANDING_HEIGHT = float(FOOT_RADIUS - FEMUR * sin(FEMUR_PITCH) - TIBIA * sin(TIBIA_PITCH))

_LENGTHS = dict(zip(SEGMENTS, (COXA, FEMUR, TIBIA), strict=True))
_PLURALS = dict(zip(SEGMENTS, ("coxae", "femora", "tibiae"), strict=True))
_OF = {"": "", **{f"row{row}.": f" of row {row}" for row in "1234"}} | {
    f"{leg}.": f" of {leg}" for leg in LEGS
}
DIMENSIONS = {
    of + segment: Dimension("m", length, f"length of the {_PLURALS[segment]}{legs}")
    for of, legs in _OF.items()
    for segment, length in _LENGTHS.items()
} | {
    "hips.length": Dimension("m", 0.15, "distance of the front from the rear hips"),
    "hips.width": Dimension("m", 2 * HIP_Y, "distance of the left from the right hips"),
}
_SCALED = (*SEGMENTS, "length", "width")


class Sizes:
    """The lengths of legs and the places of hips of one or more bodies.

    The factor of a length is the product of those of all legs, of the row, and of the leg.

    Args:
        factors: factors of dimensions by name, numbers or (bodies,); the others are 1.

    Attributes:
        scales: factors of the lengths of coxa, femur and tibia, (bodies, 8, 3).
        lengths: the lengths, (bodies, 8, 3) m.
        hip_x: distances of the hips ahead of the middle, (bodies, 8) m.
        hip_y: distances of the hips from the middle, towards the leg's side, (bodies, 8) m.
    """

    def __init__(self, factors: Mapping[str, Any]) -> None:
        bodies = max((np.size(one) for one in factors.values()), default=1)
        scale = np.ones((bodies, len(LEGS), len(_SCALED)))
        for name in DIMENSIONS:  # in one order, on which rounding depends
            if name in factors:
                where, _, size = name.rpartition(".")
                legs = [where in ("", "hips", f"row{leg[1]}", leg) for leg in LEGS]
                scale[:, legs, _SCALED.index(size)] *= np.reshape(factors[name], (-1, 1))
        self.scales = scale[..., :3]
        self.lengths = np.array([COXA, FEMUR, TIBIA]) * self.scales
        self.hip_x, self.hip_y = HIP_X * scale[..., 3], HIP_Y * scale[..., 4]


ANGLE_LIMIT = math.radians(30.0)  # largest angle of every joint, either way from rest
STEP_LIMIT = math.radians(5.0)  # largest change per frame, which is 150 °/s


def time_second(array: Array) -> Array:
    """View (population, …, frames) as the channel (population, frames, …), axes reversed."""
    return array.transpose(0, *range(array.ndim - 1, 0, -1))


def time_last(channel: Array) -> Array:
    """Invert `time_second`; contiguous, and a copy only if the channel is not such a view."""
    return np.ascontiguousarray(time_second(channel))
