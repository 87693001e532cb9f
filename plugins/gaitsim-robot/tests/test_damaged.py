"""Damaged robots against bodies without the leg or joint, and against weaker servos."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.legged import SERVOS
from gaitsim_robot.loading import load_servos, load_specification
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import walk
from gaitsim_robot.simulation import build

GRAVITY = 9.81
DOG = Path(__file__).parent / "fixtures/robots/dog_description/urdf/dog.urdf"
HEXAPOD = {"model": "hexapod", "servo": "sts3215"}
FRAMES = 101


def swaying(robot):
    """Return commands that swing all joints around the standing pose, (1, FRAMES, joints) rad."""
    simulation, time = robot.simulation, np.arange(FRAMES)[:, None] / 50
    joints = len(simulation.ctrl)
    sway = 0.2 * np.minimum(time, 1) * np.sin(2 * np.pi * time + np.arange(joints))
    intact = robot.anatomy.stance[simulation.qpos]
    return (intact + sway)[None]


def altered_simulation(robot, missing, alter):
    """Return a simulation from an altered specification, which lacks some joints."""
    spec = load_specification(robot.text)
    alter(spec)
    anatomy = robot.anatomy
    model = robot.simulation.model
    legs = [
        replace(leg, joints=tuple(name for name in leg.joints if name not in missing))
        for leg in anatomy.legs
    ]
    stance = np.delete(anatomy.stance, [model.joint(name).qposadr[0] for name in missing])
    anatomy = replace(
        anatomy,
        legs=tuple(leg for leg in legs if leg.joints),
        stance=stance,
        mass=robot.simulation.anatomy.mass,
    )
    servos = load_servos(robot.text, robot.anatomy, (robot.servo, None, None, None, None))
    servos = {name: servo for name, servo in servos.items() if name not in missing}
    spec.delete(spec.keys[0])
    return build(spec, anatomy, servos, dt=robot.dt, friction=robot.friction, gravity=GRAVITY)


def delete_leg(spec):
    spec.delete(spec.body("L2 coxa"))


def weld_femur(spec):
    joint = spec.joint("L2 femur")
    femur, turn, welded = joint.parent, np.empty(4), np.empty(4)
    mujoco.mju_axisAngle2Quat(turn, joint.axis, np.radians(25))
    mujoco.mju_mulQuat(welded, femur.quat, turn)
    spec.delete(joint)
    femur.quat = welded


@pytest.mark.parametrize(
    ("damage", "missing", "alter"),
    [
        ("L2 lost", ("L2 coxa", "L2 femur", "L2 tibia"), delete_leg),
        ("L2 femur stuck 25", ("L2 femur",), weld_femur),
    ],
)
def test_a_damaged_robot_moves_like_one_without_the_leg_or_joint(damage, missing, alter):
    robot = Robot(**HEXAPOD, damage=(damage,))
    commands = swaying(robot)
    found = robot.play(commands)
    reference = altered_simulation(robot, missing, alter)
    kept = [name not in missing for name in robot.joint_names()]
    expected = walk(reference, commands[..., kept])
    assert robot.simulation.stands
    assert reference.stands
    assert found["lasted"] == expected["lasted"] == 2.0
    assert np.ptp(found["torso"], axis=1).max() > 0.01
    for channel, tolerance in (("torso", 2e-3), ("orientation", 0.02)):
        np.testing.assert_allclose(found[channel], expected[channel], atol=tolerance)
    assert found["energy"][0, -1] == pytest.approx(expected["energy"][0, -1], rel=0.01)
    angles = found["joint_positions"][0][:, [name in missing for name in robot.joint_names()]]
    assert np.degrees(np.ptp(angles, axis=0)).max() < 0.05
    assert not found["torque"][0][:, [not one for one in kept]].any()


def test_a_lost_leg_has_no_weight_and_carries_no_load():
    robot = Robot(**HEXAPOD, damage=("L2 lost",))
    simulation, intact = robot.simulation, Robot(**HEXAPOD)
    rest = np.repeat(simulation.rest[simulation.ctrl][None, None], 251, axis=1)
    motion = robot.play(rest)
    weight = (intact.anatomy.mass - 0.065 - 0.07 - 0.03) * GRAVITY
    assert motion["weight"] == pytest.approx(weight)
    assert motion["load"][0, -1, :, 2].sum() == pytest.approx(weight, rel=0.005)
    leg = [one.name for one in robot.anatomy.legs].index("L2")
    assert not motion["load"][0, :, leg].any()
    assert not motion["stance"][0, :, leg].any()
    hip = motion["foot_positions"][0, -1, leg] - motion["torso"][0, -1]
    assert hip == pytest.approx([0, 0.08, 0], abs=2e-3)  # where the file attaches the leg
    assert motion["slip"].max() < 1e-3
    space, expected = robot.genome_space(), intact.genome_space()
    np.testing.assert_array_equal([space.lower, space.upper], [expected.lower, expected.upper])


@pytest.mark.parametrize(
    ("damage", "options"), [("weak 0.5", {"torque_limit": 0.5}), ("slow 0.5", {"speed_limit": 0.5})]
)
def test_weak_and_slow_joints_have_servos_with_less_torque_or_speed(damage, options):
    every = Robot(servo="ax-12a").joint_names()
    (name, share), servo = *options.items(), SERVOS["ax-12a"]
    limit = share * (servo.stall_torque if name == "torque_limit" else servo.no_load_speed)
    damaged = Robot(servo="ax-12a", damage=tuple(f"{joint} {damage}" for joint in every))
    expected = Robot(servo="ax-12a", **{name: limit})
    commands = swaying(expected)
    found, wanted = damaged.play(commands), expected.play(commands)
    for channel in found:
        np.testing.assert_array_equal(found[channel], wanted[channel])


def test_joints_without_force_or_speed_are_limp_or_stuck():
    robot = Robot(**HEXAPOD, damage=("L1 tibia weak 0", "R1 femur slow 0"))
    motion = robot.play(swaying(robot))
    limp, still = (robot.joint_names().index(name) for name in ("L1 tibia", "R1 femur"))
    assert not motion["torque"][..., [limp, still]].any()
    assert np.ptp(motion["joint_positions"][0, :, limp]) > 0.1
    assert np.ptp(motion["joint_positions"][0, :, still]) < 1e-3
    assert np.isfinite(robot.simulation.effort).all()
    assert [*robot.describe()["Damage"]] == [*robot.damage]


def test_a_lost_leg_deactivates_mimic_joints_and_closed_linkages():
    spec = load_specification(Robot().text)
    for side in "LR":
        spec.body(f"{side}1 shank").add_site(name=f"{side}1 toe", pos=[0, 0, -0.1])
    spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1="L1 knee", name2="R1 knee")
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        name1="L1 toe",
        name2="R1 toe",
    )
    damage = ("L1 lost", "R2 knee stuck -60")
    robot = Robot(damage=damage)
    args = robot.anatomy, load_servos(robot.text, robot.anatomy, ("model", None, None, None, None))
    linked = build(
        spec, *args, dt=0.004, friction=0.8, gravity=GRAVITY, damage=robot.simulation.damage
    )
    commands = swaying(robot)
    found, expected = walk(linked, commands), robot.play(commands)
    np.testing.assert_array_equal(found["configuration"], expected["configuration"])


def test_a_skeleton_omits_lost_legs_and_names_the_parts_that_damaged_joints_move():
    robot = Robot(**HEXAPOD, damage=("L1 lost", "R1 femur stuck"))
    skeleton = robot.skeleton(robot.play(swaying(robot)), 0)
    drawn = [*skeleton.names, *(solid.name for solid in skeleton.solids)]
    assert not [name for name in drawn if name.startswith("L1") and "hip" not in name]
    assert {*skeleton.damaged} == {"L1", "R1 femur"}
    assert skeleton.contact_names == tuple(robot.leg_joints())


@pytest.mark.slow
def test_a_robot_from_a_file_can_be_damaged_until_it_falls():
    legs = Robot(model=str(DOG)).leg_joints()
    robot = Robot(
        model=str(DOG), damage=("L1 lost", "L2 lost", f"{legs['R1'][0]} stuck 30"), duration=1.0
    )
    motion = robot.play(swaying(robot))
    assert not robot.simulation.stands
    assert motion["lasted"] < 1.0
    assert not motion.failures


@pytest.mark.parametrize(
    ("damage", "named"),
    [
        ("L4 lost", "L1, R1, L2, R2"),
        ("L1 elbow stuck", "L1 knee"),
        ("L1 knee stuck 60", "-137.5° to -11.46°"),
    ],
)
def test_invalid_damage_is_refused(damage, named):
    with pytest.raises(GaitsimError) as caught:
        Robot(damage=(damage,))
    assert caught.value.key == "damage"
    assert named in str(caught.value)
