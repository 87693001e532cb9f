"""Damaged spiders: lost legs, and stuck or slow joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.toolkit import Kind, limit_steps, parse_damage
from gaitsim_spider import body

KINDS: tuple[Kind, ...] = ("lost", "stuck", "slow")
_LIMITS = -body.ANGLE_LIMIT, body.ANGLE_LIMIT
_MASSES = (body.COXA_MASS, body.FEMUR_MASS, body.TIBIA_MASS)


class LegData(NamedTuple):
    """Data of the legs for the kernels; a lost leg has no length and no mass.

    Attributes:
        lengths: lengths of coxa, femur and tibia, (8, 3) float32, m.
        shares: shares of coxa, femur and tibia in the mass of the whole body, (8, 3) float32.
        hips: first moment of the legs' masses, if all are at the hips, divided by the mass of the
            body, (3,) float32, m; exactly 0 for an intact body, whose hips cancel in pairs.
    """

    lengths: NDArray[np.float32]
    shares: NDArray[np.float32]
    hips: NDArray[np.float32]


Legs = LegData  # its name in kernels that earlier versions cached


@dataclass(frozen=True, eq=False)
class SpiderAnatomy:
    """The anatomy of a body with its damage.

    Attributes:
        legs: data of the legs for the kernels.
        lost: whether each leg is lost, (8,) bool.
        held: angles of the joints that do not move, by index, rad; 0 in lost legs.
        step_limits: largest rotation of each joint per frame, (24,) rad.
        damaged: names of the lost legs, and of the stuck and slow joints.
    """

    legs: LegData
    lost: NDArray[np.bool_]
    held: Mapping[int, float]
    step_limits: NDArray[np.float64]
    damaged: tuple[str, ...]

    def restrict(self, angles: NDArray[np.float32]) -> NDArray[np.float32]:
        """Limit angles, (population, 24, frames) rad, in place to the reach of damaged joints."""
        slow = np.flatnonzero(self.step_limits < body.STEP_LIMIT)
        if len(slow):
            angles[:, slow] = limit_steps(angles[:, slow], self.step_limits[slow])
        for joint, angle in self.held.items():
            angles[:, joint] = angle
        return angles


@lru_cache
def damaged_anatomy(damage: tuple[str, ...], leg_mass: float = 1.0) -> SpiderAnatomy:
    """Return the anatomy of a damaged body.

    Args:
        damage: texts such as 'L2 lost', one for each damaged part.
        leg_mass: scale factor of the legs' masses.
    """
    for text in damage:
        if "weak" in text.split():
            raise GaitsimError(
                f"{text!r}: the spider moves without forces, so its joints cannot be weak",
                key="damage",
                allowed=", ".join(KINDS),
                remedy="use the preset 'spider-physics', a spider in rigid-body physics",
            )
    found = parse_damage(damage, body.LEG_JOINTS, KINDS, dict.fromkeys(body.JOINTS, _LIMITS))
    lost = np.isin(body.LEGS, [one.part for one in found])
    held = dict.fromkeys(np.flatnonzero(np.repeat(lost, len(body.SEGMENTS))).tolist(), 0.0)
    step_limits = np.full(len(body.JOINTS), body.STEP_LIMIT)
    for one in found:
        if one.kind == "stuck":
            held[body.JOINTS.index(one.part)] = one.value or 0.0
        elif one.kind == "slow" and one.value is not None:
            step_limits[body.JOINTS.index(one.part)] *= one.value
    return SpiderAnatomy(
        _legs(lost, leg_mass), lost, held, step_limits, tuple(one.part for one in found)
    )


def _legs(lost: NDArray[np.bool_], leg_mass: float) -> LegData:
    coxa, femur, tibia = masses = [leg_mass * mass for mass in _MASSES]
    whole = coxa + femur + tibia  # `sum` of floats differs between versions of Python
    mass = body.BODY_MASS + int((~lost).sum()) * whole
    lengths, shares = np.zeros((2, len(lost), 3), np.float32)
    lengths[~lost] = (body.COXA, body.FEMUR, body.TIBIA)
    shares[~lost] = np.divide(masses, mass)
    hips = np.stack([body.HIP_X, body.SIDE * body.HIP_Y, np.zeros(len(lost))], axis=1)
    moment = hips[~lost].sum(axis=0) * whole / mass
    return LegData(lengths, shares, moment.astype(np.float32))
