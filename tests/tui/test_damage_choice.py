"""Damage as keys and dialogs change it."""

from gaitsim.legged.damage import Damage, damage_options, parse_damage
from gaitsim.tui.damage_choice import texts, with_joint, with_leg

LEGS = {name: (f"{name} coxa", f"{name} femur") for name in ("L1", "L2", "R1")}


def test_a_leg_goes_and_comes_back_intact():
    stuck = parse_damage(["L2 femur stuck 20"], LEGS)
    lost = with_leg(stuck, "L2", LEGS)
    assert texts(lost) == ("L2 lost",)
    assert with_leg(lost, "L2", LEGS) == ()


def test_a_joint_has_one_damage_and_none_while_its_leg_is_lost():
    lost = with_leg((), "L2", LEGS)
    slow = with_joint(lost, "L2 femur", Damage("L2 femur", "slow", 0.25), LEGS)
    assert texts(slow) == ("L2 femur slow 0.25",)
    stuck = with_joint(slow, "L2 femur", Damage("L2 femur", "stuck"), LEGS)
    assert texts(stuck) == ("L2 femur stuck",)
    assert with_joint(stuck, "L2 femur", None, LEGS) == ()


def test_the_same_damage_has_the_same_text_whatever_came_first():
    one = with_leg(with_leg((), "R1", LEGS), "L1", LEGS)
    other = with_leg(with_leg((), "L1", LEGS), "R1", LEGS)
    assert one == other == parse_damage(texts(one), LEGS)
    assert damage_options(texts(one)) == ["--damage", "L1 lost", "--damage", "R1 lost"]
