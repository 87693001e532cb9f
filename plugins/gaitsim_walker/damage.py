"""Damaged walkers: lost legs, and stuck, weak or slow joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import parse_damage
from gaitsim_walker.body import Floats, WalkerPlan


@dataclass(frozen=True, eq=False)
class Impairment:
    """The damage of a walker.

    Attributes:
        lost: whether each leg is lost, (legs,) bool.
        held: angles of stuck joints by index, rad.
        torque: remaining share of each joint's torque, (joints,); 0 in lost legs and stuck joints.
        speed: remaining share of each joint's speed, (joints,).
        parts: names of the lost legs, and of the segments below damaged joints.
    """

    lost: NDArray[np.bool_]
    held: Mapping[int, float]
    torque: Floats
    speed: Floats
    parts: tuple[str, ...]

    def restrict(self, commands: Floats) -> Floats:
        """Return commands, (…, joints) rad, with the angles of stuck joints, and 0 in lost legs."""
        if not self.parts:
            return commands
        restricted = np.where(np.repeat(self.lost, 2), 0.0, commands)
        for joint, angle in self.held.items():
            restricted[..., joint] = angle
        return restricted


@lru_cache
def impairment_of(damage: tuple[str, ...], plan: WalkerPlan) -> Impairment:
    """Return the damage that texts such as 'near fore lost' describe.

    A joint without speed is stuck at its angle in the standing pose.
    """
    joints, legs = plan.joints, [leg.name for leg in plan.legs]
    by_leg = {leg: joints[2 * at : 2 * at + 2] for at, leg in enumerate(legs)}
    limits = {
        name: (-limit, limit) for name, limit in zip(joints, plan.limits.tolist(), strict=True)
    }
    found = parse_damage(damage, by_leg, limits=limits)
    lost = np.isin(legs, [one.part for one in found if one.kind == "lost"])
    held, speed = {}, np.ones(len(joints))
    torque = np.where(np.repeat(lost, 2), 0.0, 1.0)
    for one in found:
        at, value = joints.index(one.part) if one.part in joints else -1, one.value
        if one.kind == "stuck" or (one.kind == "slow" and not value):
            held[at], torque[at] = value or 0.0, 0.0
        elif one.kind == "slow" and value is not None:
            speed[at] = value
        elif one.kind == "weak" and value is not None:
            torque[at] = value
    return Impairment(lost, held, torque, speed, tuple(_segment(one.part) for one in found))


def _segment(part: str) -> str:
    """Return the segment below a joint; the name of a leg is unchanged."""
    return part.replace(" hip", " thigh").replace(" knee", " shank")
