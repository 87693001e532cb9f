"""Changes to the choice of damaged legs and joints of a body."""

from collections.abc import Mapping

from gaitsim.legged.damage import Damage

Legs = Mapping[str, tuple[str, ...]]
Choice = tuple[Damage, ...]


def toggle_leg(damage: Choice, leg: str, legs: Legs) -> Choice:
    """Return the damage with a leg lost, or restored if it was lost, and its joints intact."""
    was_lost = any(one.part == leg for one in damage)
    kept = tuple(one for one in damage if one.part not in (leg, *legs[leg]))
    return kept if was_lost else sort_damage((*kept, Damage(leg, "lost")), legs)


def set_joint(damage: Choice, joint: str, new: Damage | None, legs: Legs) -> Choice:
    """Return the damage with `new` damage to a joint, None for intact, and its leg restored."""
    leg = next(leg for leg, joints in legs.items() if joint in joints)
    kept = tuple(one for one in damage if one.part not in (leg, joint))
    return sort_damage((*kept, *((new,) if new else ())), legs)


def sort_damage(damage: Choice, legs: Legs) -> Choice:
    """Return the damage in the order of the legs, so that equal damage has equal text."""
    order = [part for leg, joints in legs.items() for part in (leg, *joints)]
    return tuple(sorted(damage, key=lambda one: order.index(one.part)))


def damage_texts(damage: Choice) -> tuple[str, ...]:
    """Return damage in the syntax of `--damage`, one string per part."""
    return tuple(map(str, damage))
