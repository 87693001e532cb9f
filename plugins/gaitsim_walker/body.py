"""The walker's body: its parts, their sizes, masses and positions.

In the plane, x points forward and z up. Positive angles turn x towards z, so a positive pitch
lifts the nose. A leg consists of a thigh and a shank, of equal length unless dimensions change.
Joint angles are offsets from the stance, in which every knee is bent by 60° and each foot is below
its hip. A positive hip angle swings the leg forward; a positive knee angle bends the knee further.
Fore knees point backward like a dog's elbows, all others forward.

Thigh and shank are thin rods, and the torso is a box. Their masses are proportional to their
lengths, and their moments of inertia are those of the new rod or box.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Dimension, Link, Rig, turn_about_axis

TORSO_LENGTH, TORSO_HEIGHT = 0.50, 0.12  # m; a biped's torso is upright
TORSO_MASS, THIGH_MASS, SHANK_MASS = 6.0, 0.6, 0.3  # kg
FRAME_RATE = 60.0  # Hz, for both servo commands and recorded frames
LIMB = 0.20  # m, nominal length of each thigh and of each shank
FOOT_RADIUS, KNEE_RADIUS = 0.025, 0.02  # m
HIP_OFFSET = 0.20  # m, distance of a four-legged walker's hips from the torso's middle
BEND = math.radians(30)  # half the angle of the knee at rest
HIP_LIMIT, KNEE_LIMIT = math.radians(60), math.radians(50)
STOP = math.radians(5)  # angle from a limit to the joint's mechanical stop beyond it
DIMENSIONS = {
    "thigh": Dimension("m", LIMB, "length of the thighs"),
    "shank": Dimension("m", LIMB, "length of the shanks"),
    "trunk": Dimension("m", TORSO_LENGTH, "length of the torso, with its hips"),
}

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
        length: length of the torso, m.
        limbs: lengths of each thigh and of each shank, m.
    """

    legs: tuple[WalkerLeg, ...]
    half: tuple[float, float]
    length: float
    limbs: tuple[float, float]

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
    def torso_mass(self) -> float:
        """Mass of the torso, kg."""
        return self.length / TORSO_LENGTH * TORSO_MASS

    @property
    def limb_masses(self) -> tuple[float, float]:
        """Masses of each thigh and of each shank, kg."""
        thigh, shank = self.limbs
        return thigh / LIMB * THIGH_MASS, shank / LIMB * SHANK_MASS

    @property
    def leg_mass(self) -> float:
        """Mass of a leg, kg."""
        thigh, shank = self.limb_masses
        return thigh + shank

    @property
    def mass(self) -> float:
        """Mass of the whole body, kg."""
        return self.torso_mass + len(self.legs) * self.leg_mass

    @property
    def bends(self) -> tuple[float, float]:
        """Angles of thigh and shank from the vertical at rest, rad: the foot is below the hip."""
        thigh, shank = self.limbs
        if thigh == shank:
            return BEND, BEND
        bend = math.atan2(shank * math.sin(2 * BEND), thigh + shank * math.cos(2 * BEND))
        return bend, 2 * BEND - bend

    @property
    def compensation(self) -> float:
        """Hip angle per knee angle that keeps the foot below the hip, to first order; usually ½."""
        thigh, shank = (
            limb * math.cos(bend) for limb, bend in zip(self.limbs, self.bends, strict=True)
        )
        return shank / (thigh + shank)

    @property
    def limits(self) -> Floats:
        """Largest offset of each joint from the stance, (joints,) rad."""
        return np.tile([HIP_LIMIT, KNEE_LIMIT], len(self.legs))


@lru_cache
def plan_of(legs: int, thigh: float = 1.0, shank: float = 1.0, trunk: float = 1.0) -> WalkerPlan:
    """Return the build of a walker on two or four legs, given the factors of its dimensions."""
    length, limbs = trunk * TORSO_LENGTH, (thigh * LIMB, shank * LIMB)
    if legs == 2:
        hip = (0.0, -length / 2)
        pair = tuple(WalkerLeg(side, hip, 1) for side in ("near", "far"))
        return WalkerPlan(pair, (TORSO_HEIGHT / 2, length / 2), length, limbs)
    places = ("fore", trunk * HIP_OFFSET, -1), ("hind", -trunk * HIP_OFFSET, 1)
    four = tuple(
        WalkerLeg(f"{side} {end}", (x, -TORSO_HEIGHT / 2), knee)
        for side in ("near", "far")
        for end, x, knee in places
    )
    return WalkerPlan(four, (length / 2, TORSO_HEIGHT / 2), length, limbs)


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
    thigh = hips + direction * plan.bends[0]
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
    for part, length in enumerate(plan.limbs):
        angle = turned[..., part::2]
        where[..., part + 1, 0] = where[..., part, 0] + length * np.sin(angle)
        where[..., part + 1, 1] = where[..., part, 1] - length * np.cos(angle)
    return where


def to_3d(flat: Floats) -> Floats:
    """Insert y = 0 between x and z, (…, 2) -> (…, 3)."""
    points = np.zeros((*flat.shape[:-1], 3))
    points[..., 0], points[..., 2] = flat[..., 0], flat[..., 1]
    return points


TRUNK = "torso"


def rig(plan: WalkerPlan, lost: Sequence[bool], damaged: tuple[str, ...]) -> Rig:
    """Return the rig of a walker.

    Links turn about y. In its own frame, a thigh or shank hangs down.

    Args:
        plan: build of the body.
        lost: whether each leg is lost.
        damaged: names of damaged parts.
    """
    # Both ends of a thigh and of a shank, in their own frames.
    thigh_ends, shank_ends = (np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -one]]) for one in plan.limbs)
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
        feet.append(np.array([x, 0.0, z]) if gone else shank_ends[1])
        foot_links.append(TRUNK if gone else shank)
        if gone:
            continue
        bend, bent = direction * plan.bends[0], direction * 2 * BEND
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
                (0.0, 0.0, -plan.limbs[0]),
                turn_about_axis(1, bent),
                f"{leg.name} knee",
                (0.0, direction, 0.0),
            ),
        ]
        names += [thigh, shank]
        carriers += [thigh, shank]
        ends += [thigh_ends, shank_ends]
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
