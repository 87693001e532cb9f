"""Damage to legs and joints, as users write it: 'L2 lost', 'R1 femur stuck 20'."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from gaitsim.errors import GaitsimError, unknown

Kind = Literal["lost", "stuck", "weak", "slow"]
KINDS: tuple[Kind, ...] = get_args(Kind)
TOLERANCE = 1e-4  # rad, for limits that a file gives with few digits, such as ±0.5236
DEFAULT_SHARE = 0.5  # remaining share of torque or speed


@dataclass(frozen=True)
class Damage:
    """One damaged leg or joint.

    Attributes:
        part: name of the lost leg, or of the damaged joint.
        kind: 'lost', 'stuck' at an angle, 'weak' with less torque, or 'slow' with less speed.
        value: for a stuck joint, its angle in rad, or None for the angle in the standing pose. For
            a weak or slow joint, the remaining share of torque or speed, 0 to 1. For a lost leg,
            None.
    """

    part: str
    kind: Kind
    value: float | None = None

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.part} {self.kind}"
        value = math.degrees(self.value) if self.kind == "stuck" else self.value
        return f"{self.part} {self.kind} {value:.6g}"


def damage_options(damage: Sequence[str]) -> list[str]:
    """Return the command-line options for a list of damages."""
    return [word for text in damage for word in ("--damage", text)]


def parse_damage(
    texts: Sequence[str],
    legs: Mapping[str, Sequence[str]],
    kinds: Sequence[Kind] = KINDS,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[Damage, ...]:
    """Parse descriptions of damage.

    Args:
        texts: one string for each damaged part.
        legs: joints of each leg of the body, by the name of the leg.
        kinds: kinds of damage that the body supports.
        limits: smallest and largest angle of each joint, rad; None for no limits.

    Raises:
        GaitsimError: a string is invalid, the body lacks a part, a part is damaged twice, a joint
            is stuck outside its limits, or no leg is left.
    """
    found = [_parse_one(text, legs, kinds) for text in texts]
    parts = [damage.part for damage in found]
    for damage in found:
        leg = next((leg for leg, joints in legs.items() if damage.part in joints), "")
        if parts.count(damage.part) > 1 or (damage.kind != "lost" and leg in parts):
            raise GaitsimError(
                f"{damage.part!r} is damaged twice"
                if leg not in parts
                else f"{damage.part!r} is a joint of {leg!r}, which is lost",
                key="damage",
                allowed="one damage for each leg or joint",
            )
        if damage.kind == "stuck" and damage.value is not None and limits:
            _check_angle(damage.part, damage.value, *limits[damage.part])
    if legs and all(leg in parts for leg in legs):
        raise GaitsimError(
            "all legs are lost", key="damage", allowed=f"at most {len(legs) - 1} lost legs"
        )
    return tuple(found)


def _parse_one(text: str, legs: Mapping[str, Sequence[str]], kinds: Sequence[Kind]) -> Damage:
    words = text.split()
    value = _number(words[-1]) if len(words) > 2 else None
    if value is not None:
        words.pop()
    kind = next((kind for kind in kinds if words[-1:] == [kind]), None)
    part = " ".join(words[:-1])
    if kind is None or not part or (kind == "lost" and value is not None):
        raise GaitsimError(
            f"invalid damage {text!r} for this body", key="damage", allowed=_examples(legs, kinds)
        )
    joints = [joint for names in legs.values() for joint in names]
    known = [*legs] if kind == "lost" else joints
    if part not in known:
        raise unknown("leg" if kind == "lost" else "joint", part, known, key="damage")
    if kind == "stuck" and value is not None and not abs(value) <= 360:
        raise GaitsimError(
            f"invalid angle in the damage {text!r}", key="damage", allowed="-360 to 360 degrees"
        )
    if kind in ("weak", "slow"):
        value = DEFAULT_SHARE if value is None else value
        if not 0 <= value <= 1:
            raise GaitsimError(
                f"invalid remaining share in the damage {text!r}",
                key="damage",
                allowed="0 to 1, the share of torque or speed that remains",
            )
    return Damage(part, kind, math.radians(value) if kind == "stuck" and value else value)


def _check_angle(joint: str, angle: float, lower: float, upper: float) -> None:
    if not lower - TOLERANCE <= angle <= upper + TOLERANCE:
        raise GaitsimError(
            f"the stuck angle of joint {joint!r}, {math.degrees(angle):.4g}°, is outside the "
            "joint's limits",
            key="damage",
            allowed=f"{math.degrees(lower):.4g}° to {math.degrees(upper):.4g}°",
        )


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _examples(legs: Mapping[str, Sequence[str]], kinds: Sequence[Kind]) -> str:
    leg = next(iter(legs), "LEG")
    joint = next((joint for joints in legs.values() for joint in joints), "JOINT")
    examples: dict[Kind, str] = {
        "lost": f"'{leg} lost'",
        "stuck": f"'{joint} stuck 20' (degrees)",
        "weak": f"'{joint} weak 0.5'",
        "slow": f"'{joint} slow 0.5' (remaining share)",
    }
    return ", ".join(examples[kind] for kind in kinds)
