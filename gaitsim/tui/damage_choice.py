"""Which legs and joints of a body are damaged, as keys and dialogs change it."""

from collections.abc import Mapping

from gaitsim.legged.damage import Damage

Legs = Mapping[str, tuple[str, ...]]
Choice = tuple[Damage, ...]


def with_leg(damage: Choice, leg: str, legs: Legs) -> Choice:
    """Return the damage with a leg lost, or intact if it was lost; its joints are intact then."""
    was_lost = any(one.part == leg for one in damage)
    kept = tuple(one for one in damage if one.part not in (leg, *legs[leg]))
    return kept if was_lost else ordered((*kept, Damage(leg, "lost")), legs)


def with_joint(damage: Choice, joint: str, new: Damage | None, legs: Legs) -> Choice:
    """Return the damage with a joint's replaced, None for an intact one; its leg is not lost."""
    leg = next(leg for leg, joints in legs.items() if joint in joints)
    kept = tuple(one for one in damage if one.part not in (leg, joint))
    return ordered((*kept, *((new,) if new else ())), legs)


def ordered(damage: Choice, legs: Legs) -> Choice:
    """Return the damage in the order of the legs, so that the same damage has the same text."""
    order = [part for leg, joints in legs.items() for part in (leg, *joints)]
    return tuple(sorted(damage, key=lambda one: order.index(one.part)))


def texts(damage: Choice) -> tuple[str, ...]:
    """Return damage as `--damage` takes it, a text for each part."""
    return tuple(map(str, damage))
