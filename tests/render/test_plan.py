"""Plans of a body's legs: positions, marks of damage, and neighbours."""

import numpy as np
import pytest

from gaitsim.contracts import Skeleton
from gaitsim.render.terminal import plan as drawing
from gaitsim.render.terminal.plan import draw_plan, leg_at, next_leg, plan_of

LEGS = {name: (f"{name} hip", f"{name} knee") for name in ("L1", "R1", "L2", "R2", "L3", "R3")}
SIZE = (40, 16)


@pytest.fixture
def plan():
    """The plan of a trunk of 0.4 × 0.2 m with three legs, each with hip and knee, per side."""
    names, segments, feet = ["trunk"], [[[0.2, 0, 0.1], [-0.2, 0, 0.1]]], []
    for name, joints in LEGS.items():
        x, y = {"1": 0.2, "2": 0.0, "3": -0.2}[name[1]], {"L": 0.1, "R": -0.1}[name[0]]
        hip, knee, foot = np.array([x, y, 0.1]), np.array([x, 2 * y, 0.1]), np.array([x, 3 * y, 0])
        names += joints
        segments += [[hip, knee], [knee, foot]]
        feet.append(foot)
    skeleton = Skeleton(
        np.array([segments], dtype=float),
        tuple(names),
        10.0,
        contacts=np.array([feet]),
        touching=np.ones((1, 6), bool),
        contact_names=tuple(LEGS),
    )
    return plan_of(skeleton, LEGS)


def rows(plan, lost=(), damaged=(), chosen="", size=SIZE):
    codes, inks = draw_plan(plan, lost, damaged, chosen, size)
    return ["".join(map(chr, row)) for row in codes], inks


def test_the_front_is_up_and_left_is_left(plan):
    text, _ = rows(plan)
    at = {
        leg: (row, line.index(leg)) for row, line in enumerate(text) for leg in LEGS if leg in line
    }
    assert at["L1"][0] == at["R1"][0] < at["L2"][0] < at["L3"][0]
    assert at["L1"][1] == at["L3"][1] < at["R1"][1]
    assert drawing.HEAD in text[at["L1"][0]]


def test_lost_legs_are_dotted_and_damage_is_marked(plan):
    text, inks = rows(plan, lost=("L2",), damaged=("R1 knee",), chosen="L2")
    shown = "\n".join(text)
    assert "[L2✗]" in shown
    assert "R1!" in shown
    whole, _ = rows(plan)
    row = next(row for row, line in enumerate(text) if "L2" in line)
    dots = [sum(bin(ord(sign) - 0x2800).count("1") for sign in line if "⠀" < sign <= "⣿")
            for line in (text[row][:18], whole[row][:18])]  # fmt: skip
    assert 0 < dots[0] < 0.6 * dots[1]
    # The hip of R1 is unchanged; both segments of L2 are lost.
    assert {drawing.LEG, drawing.DAMAGED} <= {*inks[:, 20:].flat}
    assert drawing.LOST in inks[:, :20]
    assert drawing.LOST not in inks[:, 20:]


@pytest.mark.parametrize(
    ("leg", "way", "found"),
    [
        ("L1", (-1, 0), "L2"), ("L2", (1, 0), "L1"), ("L1", (0, -1), "R1"), ("R3", (0, 1), "L3"),
        ("L1", (1, 0), "L1"), ("R2", (0, -1), "R2"),
    ],
)  # fmt: skip
def test_arrow_keys_select_the_next_leg(plan, leg, way, found):
    assert next_leg(plan, leg, *way) == found


@pytest.mark.parametrize("size", [SIZE, (27, 12)])
def test_leg_at_finds_each_leg_where_it_is_drawn(plan, size):
    text, _ = rows(plan, size=size)
    assert [len(line) for line in text] == [size[0]] * size[1]
    for row, line in enumerate(text):
        for leg in LEGS:
            if leg in line:
                assert leg_at(plan, line.index(leg), row, size) == leg
