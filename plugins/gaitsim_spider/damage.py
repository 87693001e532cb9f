"""The legs of spiders with their dimensions and damage: lost legs, and stuck or slow joints."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

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

    There is one body for the whole population, or one for each individual.

    Attributes:
        lengths: lengths of coxa, femur and tibia, (bodies, 8, 3) float32, m.
        shares: shares of coxa, femur and tibia in the mass of the body, (bodies, 8, 3) float32.
        hips: places of the hips in the body's frame, (bodies, 8, 3) float32, m.
        moments: first moment of the legs' masses, if all are at the hips, divided by the mass of
            the body, (bodies, 3) float32, m; exactly 0 for an intact body whose rows have the same
            lengths, as its hips cancel in pairs.
    """

    lengths: NDArray[np.float32]
    shares: NDArray[np.float32]
    hips: NDArray[np.float32]
    moments: NDArray[np.float32]


Legs = LegData  # its name in kernels that earlier versions cached


@dataclass(frozen=True, eq=False)
class SpiderAnatomy:
    """The anatomy of one or more bodies with the same damage.

    Attributes:
        legs: data of the legs for the kernels.
        sizes: lengths of the legs and places of the hips, as if none were lost.
        lost: whether each leg is lost, (8,) bool.
        held: angles of the joints that do not move, by index, rad; 0 in lost legs.
        step_limits: largest rotation of each joint per frame, (24,) rad.
        damaged: names of the lost legs, and of the stuck and slow joints.
    """

    legs: LegData
    sizes: body.Sizes
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


def anatomy_of(
    factors: Mapping[str, Any], damage: tuple[str, ...], leg_mass: float = 1.0
) -> SpiderAnatomy:
    """Return the anatomy of one or more bodies with other dimensions.

    Args:
        factors: factors of dimensions by name, numbers or (bodies,).
        damage: see `damaged_anatomy`.
        leg_mass: see `damaged_anatomy`.
    """
    nominal = damaged_anatomy(damage, leg_mass)
    if not factors:
        return nominal
    sizes = body.Sizes(factors)
    return replace(nominal, legs=_legs(nominal.lost, leg_mass, sizes), sizes=sizes)


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
    sizes = body.Sizes({})
    legs, parts = _legs(lost, leg_mass, sizes), tuple(one.part for one in found)
    return SpiderAnatomy(legs, sizes, lost, held, step_limits, parts)


def _legs(lost: NDArray[np.bool_], leg_mass: float, sizes: body.Sizes) -> LegData:
    """Return the data of legs.

    Half of a segment's mass, such as its servo, is the same for all lengths; the other half grows
    with the length, as by default in the preset `spider-physics`.
    """
    masses = leg_mass * np.array(_MASSES)
    whole = masses[0] + masses[1] + masses[2]  # NumPy may choose the order of a sum
    present = np.where(lost, 0.0, 1.0)[:, None]
    own = masses * (0.5 + 0.5 * sizes.scales) * present
    gained = own - masses * present
    gained = gained[..., 0] + gained[..., 1] + gained[..., 2]
    mass = body.BODY_MASS + int((~lost).sum()) * whole + _total(gained)
    hips = np.zeros(own.shape, np.float32)
    hips[..., 0], hips[..., 1] = sizes.hip_x, body.SIDE * sizes.hip_y
    places = hips.astype(np.float64) * present
    moments = _total(places) * whole + _total(places * gained[..., None])
    return LegData(
        (sizes.lengths * present).astype(np.float32),
        (own / mass[:, None, None]).astype(np.float32),
        hips,
        (moments / mass[:, None]).astype(np.float32),
    )


def _total(by_leg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sum over the legs, (bodies, legs, …), in their order."""
    return np.asarray(np.add.accumulate(by_leg, axis=1)[:, -1])
