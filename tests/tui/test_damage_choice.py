"""Changes to the choice of damage."""

from gaitsim.legged.damage import Damage, damage_options, parse_damage
from gaitsim.tui.damage_choice import damage_texts, set_joint, toggle_leg

LEGS = {name: (f"{name} coxa", f"{name} femur") for name in ("L1", "L2", "R1")}


def test_a_leg_is_removed_and_restored_intact():
    stuck = parse_damage(["L2 femur stuck 20"], LEGS)
    lost = toggle_leg(stuck, "L2", LEGS)
    assert damage_texts(lost) == ("L2 lost",)
    assert toggle_leg(lost, "L2", LEGS) == ()


def test_a_joint_has_one_damage_and_none_while_its_leg_is_lost():
    lost = toggle_leg((), "L2", LEGS)
    slow = set_joint(lost, "L2 femur", Damage("L2 femur", "slow", 0.25), LEGS)
    assert damage_texts(slow) == ("L2 femur slow 0.25",)
    stuck = set_joint(slow, "L2 femur", Damage("L2 femur", "stuck"), LEGS)
    assert damage_texts(stuck) == ("L2 femur stuck",)
    assert set_joint(stuck, "L2 femur", None, LEGS) == ()


def test_equal_damage_has_equal_text_in_any_order():
    one = toggle_leg(toggle_leg((), "R1", LEGS), "L1", LEGS)
    other = toggle_leg(toggle_leg((), "L1", LEGS), "R1", LEGS)
    assert one == other == parse_damage(damage_texts(one), LEGS)
    assert damage_options(damage_texts(one)) == ["--damage", "L1 lost", "--damage", "R1 lost"]
