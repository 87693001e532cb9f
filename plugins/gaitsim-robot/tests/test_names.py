"""The direction of the nose that the names of legs indicate, and the names of other limbs."""

import mujoco
import numpy as np
import pytest
from small_robots import CORNERS, HUMANOID, box, leg, robot, spread_leg

from gaitsim_robot.chain import pose_data
from gaitsim_robot.facing import facings_of_names
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.limbs import Tree
from gaitsim_robot.names import is_leg


def found(text, **options):
    return find_anatomy(mujoco.MjModel.from_xml_string(text), **options)


def feet(anatomy):
    return {leg.name: leg.foot for leg in anatomy.legs}


def quadruped(*names):
    """Return a robot with legs of these names at FL, FR, RL and RR."""
    places = zip(names, CORNERS.values(), strict=True)
    return robot(box(0.4, 0.16, 0.1, 4), *(leg(name, *xy) for name, xy in places))


def hexapod(names, *parts):
    """Return a robot whose legs have these names at L1, L2, L3, R1, R2 and R3."""
    places = [(x, side) for side in (1, -1) for x in (0.1, 0.0, -0.1)]
    legs = (
        spread_leg(name, x, side * 0.06, side * np.pi / 2)
        for name, (x, side) in zip(names, places, strict=True)
    )
    return robot(box(0.2, 0.1, 0.04, 1), *legs, *parts)


def directions(text):
    model = mujoco.MjModel.from_xml_string(text)
    return facings_of_names(model, Tree(model, pose_data(model, model.qpos0)).limbs())


@pytest.mark.parametrize(
    "names",
    [
        "rr rl fr fl", "rb lb rf lf", "xhr xhl xfr xfl", "RRhip RLhip FRhip FLhip",
        "rightrear leftrear rightfront leftfront", "hindleg_r hindleg_l foreleg_r foreleg_l",
        "right_a left_a right_b left_b", "rear_a rear_b front_a front_b",
        "hinten_rechts hinten_links vorne_rechts vorne_links", "hr hl vr vl", "rhx lhx rvx lvx",
        "HinterbeinRechts HinterbeinLinks VorderbeinRechts VorderbeinLinks",
        "arrière_droite arrière_gauche avant_droite avant_gauche", "ard arg avd avg",
        "trasera_derecha trasera_izquierda delantera_derecha delantera_izquierda", "td ti dd di",
        "tra_der tra_izq del_der del_izq", "pd ps ad as",
        "posteriore_destra posteriore_sinistra anteriore_destra anteriore_sinistra",
        "traseira_direita traseira_esquerda dianteira_direita dianteira_esquerda", "td te dd de",
        "tył_prawy tył_lewy przód_prawy przód_lewy", "tylny_p tylny_l przedni_p przedni_l",
        "ushiro_migi ushiro_hidari mae_migi mae_hidari",
        "youhou zuohou youqian zuoqian", "yh zh yq zq",
    ],
)  # fmt: skip
def test_names_tell_the_direction_of_the_nose(names):
    assert directions(quadruped(*names.split())) == ["-x"]


@pytest.mark.parametrize(
    "names",
    [
        "a b c d",
        "leg1 leg2 leg3 leg4",
        "you_1 you_2 you_3 you_4",
        "hip_r_1 hip_r_2 hip_r_3 hip_r_4",
    ],
)
def test_other_names_tell_nothing(names):
    text = quadruped(*names.split())
    assert directions(text) == []
    assert found(text).warnings == ()


@pytest.mark.parametrize(
    "names",
    ["rr rm rf lr lm lf", "hr mr vr hl ml vl", "ard md avd arg mg avg", "R3 R2 R1 L3 L2 L1",
     "T3_right T2_right T1_right T3_left T2_left T1_left"],
)  # fmt: skip
def test_middle_legs_and_numbers_may_be_named(names):
    assert directions(hexapod(names.split())) == ["-x"]


def test_sides_outweigh_numbers_in_another_order():
    for names in ("L3 L2 L1 R3 R2 R1", "L1 L2 L3 R6 R5 R4", "L1 L2 L3 R3 R2 R1"):
        anatomy = found(hexapod(names.split()))
        assert feet(anatomy)["L1"] == f"{names[:2]}_tibia"
        assert bool(anatomy.warnings) == (names[1] == "3")
    (warning,) = found(hexapod(["L3", "L2", "L1", "R3", "R2", "R1"])).warnings
    assert "'L3_yaw' belongs to leg L1, front left, although its name says rear left" in warning
    assert "rename the joints" in warning


def test_sides_are_sufficient_for_a_biped():
    swapped = HUMANOID.replace("left", "x").replace("right", "left").replace("x_", "right_")
    anatomy = found(swapped)
    assert feet(anatomy) == {"L1": "left_foot", "R1": "right_foot"}
    assert "faces -x, as the names" in anatomy.notes[0]
    (warning,) = anatomy.warnings
    assert "the feet point to +x" in warning
    assert found(swapped, facing="-x").warnings == ()


@pytest.mark.parametrize(
    ("names", "facing", "warning"),
    [
        ("left_a right_a left_b right_b", "-x", "front left, although its name says right; set "
         "'organism.facing' to +x, which fits all names"),
        ("front_a front_b rear_a rear_b", "-x", "although its name says rear; set "
         "'organism.facing' to +x"),
        ("left_a left_b right_b right_a", "+x", "front right, although its name says left; set "
         "'organism.facing' to -y"),
        ("left_a right_a right_b left_b", "auto", "rear left, although its name says right; set "
         "'organism.facing' to the direction"),
        ("vr vl hr hl", "auto", "front left, although its name says front right"),
    ],
)  # fmt: skip
def test_names_that_contradict_places_are_reported(names, facing, warning):
    (reported,) = found(quadruped(*names.split()), facing=facing).warnings
    assert warning in reported


WINGS = "".join(
    f'<body name="wing_{name}" pos="0.02 {y} 0.03"><joint name="wing_yaw_{name}" axis="0 0 1" '
    f'range="-1.5 1.5"/><joint name="wing_roll_{name}" axis="1 0 0" range="-1.5 1.5"/>'
    f'<geom type="box" pos="0 {5 * y} 0" size="0.03 0.1 0.001" mass="0.004"/></body>'
    for name, y in (("left", 0.03), ("right", -0.03))
)


def test_wings_are_not_legs():
    anatomy = found(hexapod(["l1", "l2", "l3", "r1", "r2", "r3"], WINGS))
    assert [one.foot for one in anatomy.legs[::2]] == ["l1_tibia", "l2_tibia", "l3_tibia"]
    assert anatomy.notes[-1].startswith(
        "not taken for legs because of their names: wing_left, wing_right; if they are legs"
    )
    other = WINGS.replace("wing", "leg")
    assert len(found(hexapod(["l1", "l2", "l3", "r1", "r2", "r3"], other)).legs) == 8


def test_a_dog_whose_front_legs_are_named_arms_has_four_legs():
    anatomy = found(quadruped("arm_left", "arm_right", "left", "right"))
    assert len(anatomy.legs) == 4
    assert anatomy.notes == ()


@pytest.mark.parametrize(
    ("names", "leg"),
    [
        ("wing_left", False), ("antenna1 antenna2", False), ("larm lforearm lhand", False),
        ("tail_1 tail_2", False), ("claw_coxa claw_tibia", False), ("lidar mast", False),
        ("coxa_T1 tibia_T1 claw_T1", True), ("foreleg_l", True), ("FL_hip FL_foot_sensor", True),
        ("swing_l", True), ("servo_3", True),
    ],
)  # fmt: skip
def test_limbs_are_legs_unless_their_names_exclude_it(names, leg):
    assert is_leg(names.split()) == leg
