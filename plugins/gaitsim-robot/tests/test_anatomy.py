"""Legs, feet, sides and the standing pose of robots with a simple anatomy."""

import mujoco
import numpy as np
import pytest
from small_robots import ARM, CORNERS, FACING_Y, HEXAPOD, HUMANOID, QUADRUPED, WHEELS, biped, box

from gaitsim.errors import GaitsimError
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.organism import Robot

KINDS = {"quadruped": QUADRUPED, "facing y": FACING_Y, "hexapod": HEXAPOD, "humanoid": HUMANOID}


def found(text, **options):
    return find_anatomy(mujoco.MjModel.from_xml_string(text), **options)


def feet(anatomy):
    return {leg.name: leg.foot for leg in anatomy.legs}


def test_legs_are_named_front_to_back_without_an_arm():
    anatomy = found(QUADRUPED)
    assert feet(anatomy) == {"L1": "FL_shank", "R1": "FR_shank", "L2": "RL_shank", "R2": "RR_shank"}
    assert anatomy.legs[0].joints == ("FL_roll", "FL_pitch", "FL_knee")
    assert anatomy.held == ("turn", "raise")
    assert anatomy.length == pytest.approx(0.4)


def test_six_sprawling_legs_are_found():
    anatomy = found(HEXAPOD)
    assert list(feet(anatomy)) == ["L1", "R1", "L2", "R2", "L3", "R3"]
    assert [leg.foot for leg in anatomy.legs[::2]] == ["l0_tibia", "l1_tibia", "l2_tibia"]


@pytest.mark.slow
def test_the_length_of_the_trunk_is_that_of_its_box():
    # The hips are 0.4 m apart, beyond both ends of the trunk.
    assert found(QUADRUPED.replace(box(0.4, 0.16, 0.1, 4), box(0.3, 0.16, 0.1, 4))).trunk == 0.3
    # A box shorter than half of this distance, such as that of a sensor, is not a trunk.
    small = found(QUADRUPED.replace(box(0.4, 0.16, 0.1, 4), box(0.1, 0.16, 0.1, 4)))
    assert small.trunk == pytest.approx(0.4)
    humanoid = found(HUMANOID)
    assert humanoid.trunk == pytest.approx(0.16)
    assert humanoid.length == pytest.approx(humanoid.legs[0].length)


def test_a_humanoid_has_two_legs_with_soles():
    anatomy = found(HUMANOID)
    assert feet(anatomy) == {"L1": "left_foot", "R1": "right_foot"}
    assert anatomy.legs[0].sole == pytest.approx((0.22, 0.1))
    assert len(anatomy.held) == 5


@pytest.mark.slow
def test_a_robot_that_faces_y_is_turned():
    anatomy = found(FACING_Y)
    assert feet(anatomy) == feet(found(QUADRUPED))
    assert anatomy.stance[3:7] == pytest.approx([0.5**0.5, 0, 0, -(0.5**0.5)])
    assert anatomy.notes


def renamed(text, names):
    """Return a robot whose legs have other names, given by their names in `CORNERS`."""
    for old in CORNERS:
        text = text.replace(f"{old}_", f"<{old}>")
    for old, new in zip(CORNERS, names, strict=True):
        text = text.replace(f"<{old}>", f"{new}_")
    return text


@pytest.mark.parametrize(
    "names",
    [
        ("RR", "RL", "FR", "FL"),
        ("hindRight", "hindLeft", "frontRight", "frontLeft"),
        ("rb", "lb", "rf", "lf"),
        ("right_a", "left_a", "right_b", "left_b"),
    ],
)
def test_a_robot_whose_nose_points_backwards_faces_as_its_legs_are_named(names):
    anatomy = found(renamed(QUADRUPED, names))
    assert list(feet(anatomy).values()) == [f"{names[index]}_shank" for index in (3, 2, 1, 0)]
    assert np.abs(anatomy.stance[3:7]) == pytest.approx([0, 0, 0, 1], abs=1e-6)
    assert "faces -x, as the names" in anatomy.notes[0]
    assert anatomy.warnings == ()


@pytest.mark.slow
def test_the_direction_of_the_nose_can_be_given():
    backward = renamed(QUADRUPED, ["RR", "RL", "FR", "FL"])
    forward = found(backward, facing="+x")
    assert feet(forward)["L1"] == "RR_shank"
    (warning,) = forward.warnings
    assert "'RR_roll' belongs to leg L1, front left, although its name says rear right" in warning
    assert "'organism.facing' to -x" in warning
    aside = found(QUADRUPED, facing="-y")
    assert feet(aside) == {"L1": "FR_shank", "R1": "RR_shank", "L2": "FL_shank", "R2": "RL_shank"}
    assert feet(found(FACING_Y, facing="-y"))["L1"] == "RR_shank"


@pytest.mark.parametrize(
    ("names", "warns"),
    [
        (["FR", "FL", "RR", "RL"], "front left, although its name says front right"),  # mirrored
        (["a", "b", "c", "d"], ""),
        (["hip_r_a", "hip_r_b", "hip_r_c", "hip_r_d"], ""),
        (["L1", "R1", "L2", "R2"], ""),
    ],
)  # fmt: skip
def test_names_that_fit_no_direction_leave_the_robot_as_it_is_shaped(names, warns):
    anatomy = found(renamed(QUADRUPED, names))
    assert feet(anatomy)["L1"] == f"{names[0]}_shank"
    assert warns in " ".join(anatomy.warnings)
    assert bool(anatomy.warnings) == bool(warns)


def test_a_robot_whose_file_is_y_up_is_turned_upright():
    lying = HUMANOID.replace("<freejoint/>", '<freejoint/><frame euler="-1.5708 0 0">')
    anatomy = found(lying.replace("</body></worldbody>", "</frame></body></worldbody>"))
    assert feet(anatomy) == feet(found(HUMANOID))
    assert anatomy.stance[2] == pytest.approx(found(HUMANOID).stance[2], abs=1e-3)


def test_the_feet_of_a_biped_point_forward():
    backward = HUMANOID.replace("<freejoint/>", '<freejoint/><frame euler="0 0 3.14159265">')
    anatomy = found(backward.replace("</body></worldbody>", "</frame></body></worldbody>"))
    assert feet(anatomy) == feet(found(HUMANOID))
    assert np.abs(anatomy.stance[3:7]) == pytest.approx([0, 0, 0, 1], abs=1e-6)


def test_a_keyframe_is_the_standing_pose_if_the_robot_stands_in_it():
    bent = [0, 0, 0.5, 1, 0, 0, 0] + 4 * [0, 0.6, -1.2] + [0, 0]
    for knee, used in ((-1.2, True), (-2.2, False)):
        bent[9] = knee
        key = f'<keyframe><key name="stand" qpos="{" ".join(map(str, bent))}"/></keyframe>'
        anatomy = found(QUADRUPED.replace("</worldbody>", "</worldbody>" + key))
        assert (anatomy.stance[7:] == pytest.approx(bent[7:])) == used
        assert bool(anatomy.notes) != used


@pytest.mark.parametrize("text", KINDS.values(), ids=KINDS)
def test_the_robot_stands_for_two_seconds(text):
    anatomy = found(text)
    spec = mujoco.MjSpec.from_string(text)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = (1, 0) if geom.type != 0 else (0, 1)
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            servo = spec.add_actuator(
                name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT
            )
            servo.set_to_position(kp=50 * anatomy.mass, kv=anatomy.mass)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = anatomy.stance
    for servo in range(model.nu):
        data.ctrl[servo] = anatomy.stance[model.jnt_qposadr[model.actuator_trnid[servo, 0]]]
    mujoco.mj_step(model, data, round(2 / model.opt.timestep))
    assert data.qpos[2] == pytest.approx(anatomy.stance[2], rel=0.05)
    assert np.abs(data.qpos[3:7]) == pytest.approx(np.abs(anatomy.stance[3:7]), abs=0.05)


@pytest.mark.parametrize("text", KINDS.values(), ids=KINDS)
def test_the_standing_pose_has_bent_knees_within_the_limits(text):
    model = mujoco.MjModel.from_xml_string(text)
    anatomy = find_anatomy(model)
    angles = anatomy.stance[7:]
    lower, upper = model.jnt_range[1:].T
    assert (lower <= angles).all()
    assert (angles <= upper).all()
    for leg in anatomy.legs:
        knee = next(model.joint(name) for name in leg.joints if "knee" in name)
        assert abs(anatomy.stance[knee.qposadr[0]]) > 0.3


@pytest.mark.parametrize("text", [ARM, WHEELS], ids=["an arm", "wheels"])
def test_robots_without_legs_are_refused(text):
    with pytest.raises(GaitsimError, match="no legs"):
        found(text)


def test_feet_can_be_named():
    names = ["FL_shank", "FR_shank", "RL_shank", "RR_shank"]
    assert feet(found(QUADRUPED, feet=names)) == feet(found(QUADRUPED))
    with pytest.raises(GaitsimError, match="FL_shin") as failure:
        found(QUADRUPED, feet=["FL_shin"])
    assert "FL_shank" in failure.value.allowed
    with pytest.raises(GaitsimError, match="duplicate foot"):
        found(QUADRUPED, feet=["FL_shank", "FL_shank"])


def test_a_standing_pose_can_be_given_by_joint_angles():
    bent = {f"{leg}_{joint}": angle for leg in ("FL", "FR", "RL", "RR")
            for joint, angle in (("pitch", 0.6), ("knee", -1.2))}  # fmt: skip
    anatomy = found(QUADRUPED, stance=bent)
    height = 0.2 * np.cos(0.6) + 0.18 * np.cos(0.6) + 0.02
    assert anatomy.stance[2] == pytest.approx(height, abs=1e-6)
    with pytest.raises(GaitsimError, match="heights"):
        found(QUADRUPED, stance={"FL_knee": -2.0})
    with pytest.raises(GaitsimError, match="FL_nee") as failure:
        found(QUADRUPED, stance={"FL_nee": -2.0})
    assert failure.value.remedy == "did you mean 'FL_knee'?"
    with pytest.raises(GaitsimError, match="outside the joint's limits"):
        found(QUADRUPED, stance={"FL_knee": 1.0})


def test_a_shin_may_end_closely_above_the_sole():
    straight = {"left_knee": 0.0}
    for gap in (0.01, 0.004, 0.0005):
        assert feet(found(biped(gap))) == {"L1": "left_foot", "R1": "right_foot"}
        assert found(biped(gap), stance=straight).notes == ()
    with pytest.raises(GaitsimError, match="'left_shin' reaches 6 mm below the feet"):
        found(biped(-0.006), stance=straight)


def test_a_link_too_close_to_the_ground_is_named_with_its_distance():
    tail = '<body name="tail"><joint name="wag" axis="0 0 1" range="-1 1"/><geom type="capsule" '
    tail += 'fromto="-0.2 0 0 -0.4 0 {z}" size="0.01" mass="0.1"/></body></body></worldbody>'
    straight = {"left_knee": 0.0}
    low = biped(0.01).replace("</body></worldbody>", tail.format(z=-0.932))
    match = "'tail' is 8 mm above the ground, and must be at least 8.6 mm above it"
    with pytest.raises(GaitsimError, match=match):
        found(low, stance=straight)


def test_a_body_returns_the_joint_angles_of_its_standing_pose():
    names = Robot(model="quadruped").joint_names()
    bent = {name: {"pitch": 34.0, "knee": -68.0}.get(name.split()[-1], 0.0) for name in names}
    body = Robot(model="quadruped", stance=bent)
    assert np.degrees(body.standing_pose()) == pytest.approx(list(bent.values()))
