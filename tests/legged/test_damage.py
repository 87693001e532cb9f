"""Descriptions of damage."""

import math

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.legged import Damage, parse_damage

LEGS = {"L1": ("L1 coxa", "L1 femur"), "R1": ("R1 coxa", "R1 femur")}


def test_each_kind_is_parsed_with_its_value_or_a_default():
    texts = ("L1 lost", "R1 coxa stuck -20", "R1 femur weak 0.25")
    lost, stuck, weak = parse_damage(texts, LEGS)
    assert lost == Damage("L1", "lost")
    assert (stuck.part, stuck.value) == ("R1 coxa", pytest.approx(math.radians(-20)))
    assert weak == Damage("R1 femur", "weak", 0.25)
    assert parse_damage(["L1 femur slow", "R1 femur stuck"], LEGS) == (
        Damage("L1 femur", "slow", 0.5),
        Damage("R1 femur", "stuck"),
    )
    assert [str(one) for one in (lost, stuck, weak)] == list(texts)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["L1 lost 3"], "'L1 lost'"),
        (["L1 knee stuck 3"], "L1 femur"),
        (["L1 femur"], "stuck 20"),
        ([""], "'L1 lost'"),
        (["L1 femur stuck nan"], "-360 to 360"),
        (["L1 femur weak 1.5"], "0 to 1, the share"),
        (["L1 lost", "L1 lost"], "one damage"),
        (["L1 lost", "L1 femur weak"], "one damage"),
        (["L1 lost", "R1 lost"], "at most 1"),
    ],
)
def test_invalid_damage_is_refused_with_allowed_values(texts, message):
    with pytest.raises(GaitsimError) as caught:
        parse_damage(texts, LEGS)
    assert caught.value.key == "damage"
    assert message in str(caught.value)


def test_a_body_can_support_fewer_kinds_of_damage():
    with pytest.raises(GaitsimError, match="stuck") as caught:
        parse_damage(["L1 femur weak"], LEGS, ("lost", "stuck", "slow"))
    assert "weak" not in caught.value.allowed


def test_the_angle_of_a_stuck_joint_is_within_its_limits():
    limits = {"L1 femur": (-0.5236, 0.5236)}
    assert parse_damage(["L1 femur stuck 30"], LEGS, limits=limits)
    with pytest.raises(GaitsimError, match="outside the joint's limits") as caught:
        parse_damage(["L1 femur stuck 31"], LEGS, limits=limits)
    assert caught.value.allowed == "-30° to 30°"
