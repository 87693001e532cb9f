"""The walker's body: its parts, their sizes, masses and positions.

In the plane, x points forward and z up. Positive angles turn x towards z, so a positive pitch
lifts the nose. A leg consists of a thigh and a shank of equal length. Joint angles are offsets
from the stance, in which every knee is bent by 60° and each foot is below its hip. A positive hip
angle swings the leg forward; a positive knee angle bends the knee further. Fore knees point
backward like a dog's elbows, all others forward.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Link, Rig, turn_about_axis

TORSO_LENGTH, TORSO_HEIGHT = 0.50, 0.12  # m; a biped's torso is upright
TORSO_MASS, THIGH_MASS, SHANK_MASS = 6.0, 0.6, 0.3  # kg
FRAME_RATE = 60.0  # Hz, for both servo commands and recorded frames
LIMB = 0.20  # m, length of each thigh and of each shank
FOOT_RADIUS, KNEE_RADIUS = 0.025, 0.02  # m
HIP_OFFSET = 0.20  # m, distance of a four-legged walker's hips from the torso's middle
BEND = math.radians(30)  # angle of thigh and shank from the vertical at rest
HIP_LIMIT, KNEE_LIMIT = math.radians(60), math.radians(50)
STOP = math.radians(5)  # angle from a limit to the joint's mechanical stop beyond it
STANDING = 2 * LIMB * math.cos(BEND) + FOOT_RADIUS  # m, height of the hips at rest

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WalkerLeg:
    """A leg.

    Attributes:
        name: name of the leg.
        hip: x and z of the hip in the torso's frame, m.
        knee: direction in which the knee points, 1 forward or −1 backward.
    """

    name: str
    hip: tuple[float, float]
    knee: int


@dataclass(frozen=True)
class WalkerPlan:
    """The build of a walker.

    Attributes:
        legs: the legs, near ones first, front to back.
        half: half of the torso's extents along x and z at rest, m.
    """

    legs: tuple[WalkerLeg, ...]
    half: tuple[float, float]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints: hip and knee of each leg."""
        return tuple(f"{leg.name} {joint}" for leg in self.legs for joint in ("hip", "knee"))

    @property
    def sides(self) -> list[list[str]]:
        """Names of the near legs and of the far legs, front to back."""
        half = len(self.legs) // 2
        names = [leg.name for leg in self.legs]
        return [names[:half], names[half:]]

    @property
    def mass(self) -> float:
        """Mass of the whole body, kg."""
        return TORSO_MASS + len(self.legs) * (THIGH_MASS + SHANK_MASS)

    @property
    def height(self) -> float:
        """Height of the torso's middle above the ground at rest, m."""
        return STANDING - self.legs[0].hip[1]

    @property
    def limits(self) -> Floats:
        """Largest offset of each joint from the stance, (joints,) rad."""
        return np.tile([HIP_LIMIT, KNEE_LIMIT], len(self.legs))


PLANS = {
    2: WalkerPlan(
        tuple(WalkerLeg(side, (0.0, -TORSO_LENGTH / 2), 1) for side in ("near", "far")),
        (TORSO_HEIGHT / 2, TORSO_LENGTH / 2),
    ),
    4: WalkerPlan(
        tuple(
            WalkerLeg(f"{side} {end}", (x, -TORSO_HEIGHT / 2), knee)
            for side in ("near", "far")
            for end, x, knee in (("fore", HIP_OFFSET, -1), ("hind", -HIP_OFFSET, 1))
        ),
        (TORSO_LENGTH / 2, TORSO_HEIGHT / 2),
    ),
}


OUTLINE_NAMES = ("front", "bottom", "back", "top")


def outline(plan: WalkerPlan) -> Floats:
    """Return both ends of each edge of the torso in its frame, (4, 2, 3) m."""
    corners = to_3d(np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * plan.half)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def limb_angles(plan: WalkerPlan, joint_angles: Floats) -> Floats:
    """Return the angles of thighs and shanks relative to the torso; at 0, they hang straight down.

    Args:
        plan: build of the body.
        joint_angles: (…, joints) rad.

    Returns:
        (…, joints) rad: the thigh's and then the shank's angle of each leg.
    """
    hips, knees = joint_angles[..., 0::2], joint_angles[..., 1::2]
    direction = np.array([float(leg.knee) for leg in plan.legs])
    thigh = hips + direction * BEND
    turned = np.empty(joint_angles.shape)
    turned[..., 0::2], turned[..., 1::2] = thigh, thigh - direction * (2 * BEND + knees)
    return turned


def leg_points(plan: WalkerPlan, position: Floats, pitch: Floats, joint_angles: Floats) -> Floats:
    """Return the positions of each leg's hip, knee and foot in the world.

    Args:
        plan: build of the body.
        position: x and z of the torso's middle, (…, 2) m.
        pitch: pitch of the torso, (…,) rad.
        joint_angles: (…, joints) rad.

    Returns:
        x and z, (…, legs, 3, 2) m. The position of a foot is the middle of its round end.
    """
    hips = np.array([leg.hip for leg in plan.legs])
    cos, sin = np.cos(pitch)[..., None], np.sin(pitch)[..., None]
    turned = limb_angles(plan, joint_angles) + pitch[..., None]
    where = np.empty((*pitch.shape, len(plan.legs), 3, 2))
    where[..., 0, 0] = position[..., None, 0] + cos * hips[:, 0] - sin * hips[:, 1]
    where[..., 0, 1] = position[..., None, 1] + sin * hips[:, 0] + cos * hips[:, 1]
    for part in (0, 1):
        angle = turned[..., part::2]
        where[..., part + 1, 0] = where[..., part, 0] + LIMB * np.sin(angle)
        where[..., part + 1, 1] = where[..., part, 1] - LIMB * np.cos(angle)
    return where


def to_3d(flat: Floats) -> Floats:
    """Insert y = 0 between x and z, (…, 2) -> (…, 3)."""
    points = np.zeros((*flat.shape[:-1], 3))
    points[..., 0], points[..., 2] = flat[..., 0], flat[..., 1]
    return points


TRUNK = "torso"
DOWN = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -LIMB]])  # a thigh or shank in its own frame, m


def rig(plan: WalkerPlan, lost: Sequence[bool], damaged: tuple[str, ...]) -> Rig:
    """Return the rig of a walker.

    Links turn about y. In its own frame, a thigh or shank hangs down.

    Args:
        plan: build of the body.
        lost: whether each leg is lost.
        damaged: names of damaged parts.
    """
    feet, foot_links = [], []
    links, names, ends, carriers = (
        [Link(TRUNK)],
        list(OUTLINE_NAMES),
        [*outline(plan)],
        [TRUNK] * 4,
    )
    for leg, gone in zip(plan.legs, lost, strict=True):
        thigh, shank, direction = f"{leg.name} thigh", f"{leg.name} shank", float(leg.knee)
        x, z = leg.hip
        feet.append(np.array([x, 0.0, z]) if gone else DOWN[1])
        foot_links.append(TRUNK if gone else shank)
        if gone:
            continue
        bend = direction * BEND
        links += [
            Link(
                thigh,
                TRUNK,
                (x, 0.0, z),
                turn_about_axis(1, -bend),
                f"{leg.name} hip",
                (0.0, -1.0, 0.0),
            ),
            Link(
                shank,
                thigh,
                (0.0, 0.0, -LIMB),
                turn_about_axis(1, 2 * bend),
                f"{leg.name} knee",
                (0.0, direction, 0.0),
            ),
        ]
        names += [thigh, shank]
        carriers += [thigh, shank]
        ends += [DOWN, DOWN]
    return Rig(
        tuple(links),
        plan.joints,
        tuple(names),
        np.array(ends),
        tuple(carriers),
        np.array(feet),
        tuple(foot_links),
        tuple(leg.name for leg in plan.legs),
        damaged=damaged,
    )
