"""Standing poses: mirrored legs, legs that cannot bend, and poses of the file."""

import mujoco
import numpy as np
import pytest
from small_robots import HUMANOID, biped, box, robot

from gaitsim_robot.finding import find_anatomy


def found(text, **options):
    return find_anatomy(mujoco.MjModel.from_xml_string(text), **options)


def angles(text, **options):
    """Return the standing angles of the first and the second leg."""
    model = mujoco.MjModel.from_xml_string(text)
    anatomy = find_anatomy(model, **options)
    return [
        [anatomy.stance[model.joint(name).qposadr[0]] for name in leg.joints]
        for leg in anatomy.legs
    ]


def four_servo_biped():
    """Return a biped whose hips yaw and whose ankles roll."""
    legs = (
        f'<body name="{name}_leg" pos="0 {y} 0"><joint name="{name}_yaw" axis="0 0 1" '
        'range="-0.9 0.9"/><geom type="box" pos="0 0 -0.015" size="0.01 0.01 0.015" mass="0.02"/>'
        f'<body name="{name}_foot" pos="0 0 -0.03"><joint name="{name}_roll" axis="1 0 0" '
        'range="-0.9 0.9"/><geom type="box" pos="0.01 0 -0.014" size="0.04 0.0225 0.004" '
        'mass="0.03"/></body></body>'
        for name, y in (("left", 0.02), ("right", -0.02))
    )
    return robot(box(0.06, 0.07, 0.02, 0.2), *legs)


@pytest.mark.parametrize("options", [{}, {"facing": "+x"}])
def test_a_biped_with_four_servos_stands_at_zero(options):
    assert np.abs(angles(four_servo_biped(), **options)).max() == 0
    assert "bent" in found(four_servo_biped(), **options).notes[-1]


def test_legs_whose_limits_leave_them_straight_stand_at_zero():
    opposite = HUMANOID.replace('right_knee" axis="0 1 0"', 'right_knee" axis="0 -1 0"')
    assert np.abs(angles(opposite)).max() == 0


RIGHT_KNEE = 'right_knee" axis="0 1 0" range="0 2.4"'
TURNED = RIGHT_KNEE.replace("0 1 0", "0 -1 0").replace("0 2.4", "-2.4 0")


@pytest.mark.parametrize(
    ("old", "new", "sign"),
    [
        ('left_knee" axis="0 1 0" range="0 2.4"', 'left_knee" axis="0 1 0" range="0 0.9"', 1),
        (RIGHT_KNEE, RIGHT_KNEE.replace("2.4", "0.9"), 1),
        (RIGHT_KNEE, TURNED, -1),
    ],
    ids=["left knee limited", "right knee limited", "opposite axes"],
)
def test_mirrored_legs_have_mirrored_angles_within_the_limits_of_both(old, new, sign):
    left, right = np.array(angles(HUMANOID.replace(old, new)))
    assert (right == left * [-1, -1, 1, sign, 1, -1]).all()
    assert 0.5 < left[3] <= (0.9 if sign > 0 else 2.4)


def test_legs_may_be_beside_the_origin_of_the_trunk():
    beside = HUMANOID.replace("<freejoint/>", '<freejoint/><frame pos="0 0.3 0">')
    beside = beside.replace("</body></worldbody>", "</frame></body></worldbody>")
    assert np.ravel(angles(beside)) == pytest.approx(np.ravel(angles(HUMANOID)), abs=1e-6)


def test_a_load_on_one_side_is_balanced_by_different_angles():
    load = '<geom type="sphere" pos="0 0.3 0.3" size="0.05" mass="50"/>'
    left, right = np.array(angles(HUMANOID.replace("<freejoint/>", f"<freejoint/>{load}")))
    assert left[1] == pytest.approx(right[1], abs=0.02)  # both hips roll to the same side
    assert abs(left[1]) > 0.05


def test_straight_legs_of_a_keyframe_are_kept():
    pose = [0, 0, 1, 1, 0, 0, 0] + [0] * 6
    key = f'<keyframe><key name="stand" qpos="{" ".join(map(str, pose))}"/></keyframe>'
    text = biped(0.01)
    kept = found(text.replace("</worldbody>", "</worldbody>" + key))
    assert np.abs(kept.stance[7:]).max() == 0
    assert not kept.notes
    assert np.abs(found(text).stance[7:]).max() > 0.5
