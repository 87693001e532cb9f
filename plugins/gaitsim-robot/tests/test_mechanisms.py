"""Joints that a file drives have motors, others have none; linkages follow closed forms."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from mechanisms import MECHANISMS, SHANK, THIGH, hinge, mechanism, servo, two_links

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.toolkit import STRIDE_FREQUENCY
from gaitsim_robot.chain import pose_data
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.importing import import_robot
from gaitsim_robot.linkage import Linkage, chain_to
from gaitsim_robot.organism import Robot
from gaitsim_robot.text import compile_model, with_motors

DRIVEN = {
    "five_bar": (("a", "b"), ("pin_a", "pin_b")),
    "parallelogram": (("hip", "motor"), ("knee", "pin")),
    "spring_knee": (("hip",), ("knee",)),
    "toe": (("hip", "knee"), ("mtp",)),
    "mimic": (("hip",), ("knee",)),
    "pogo": (("hip",), ("slide",)),
    "driven_pogo": (("hip", "slide"), ()),
    "tendon": (("hip", "flexor"), ("knee", "ankle")),
    "linear_actuator": (("hip", "slide"), ("knee", "pin")),
}
"""Driven and passive joints of a leg."""


UNLIMITED = "five_bar", "parallelogram", "toe", "mimic", "linear_actuator"
"""Mechanisms whose passive joints have no limits."""


def read(name, folder, more=""):
    file = import_robot(name if isinstance(name, Path) else mechanism(name, folder, more))
    model = compile_model(file.text)
    return file, model, find_anatomy(model)


def chain_of(name, folder):
    """Return the model and the chain of the left front leg to the middle of its ball, at zero."""
    _, model, anatomy = read(name, folder)
    data, leg = pose_data(model, model.qpos0), anatomy.legs[0]
    joints = [model.joint(joint).id for joint in leg.joints]
    foot = model.body(leg.foot).id
    (ball,) = np.flatnonzero(
        (model.geom_bodyid == foot) & (model.geom_type == mujoco.mjtGeom.mjGEOM_SPHERE)
    )
    return model, chain_to(model, data, np.array(joints), data.geom_xpos[ball].copy(), foot)


@pytest.mark.parametrize("name", MECHANISMS)
def test_only_joints_with_an_actuator_have_a_motor(name, tmp_path):
    _, model, anatomy = read(name, tmp_path)
    driven, passive = DRIVEN[name]
    assert [leg.name for leg in anatomy.legs] == ["L1", "R1", "L2", "R2"]
    for leg, prefix in zip(anatomy.legs, ("FL", "FR", "RL", "RR"), strict=True):
        assert leg.joints == tuple(f"{prefix}_{joint}" for joint in driven)
        assert {f"{prefix}_{joint}" for joint in passive} <= {*anatomy.passive}
    assert not anatomy.held
    free = [model.joint(f"FL_{joint}").id for joint in passive]
    assert bool(model.jnt_limited[free].all()) == (name not in UNLIMITED)


def five_bar_tip(turned):
    """Return the foot relative to the middle of the hips: where two circles meet, (2,) m."""
    ends = []
    for angle, at, sign in ((turned[0], 0.02, 1), (turned[1], -0.02, -1)):
        x, z = sign * 0.06, -0.06
        ends.append([at + x * math.cos(angle) + z * math.sin(angle),
                     z * math.cos(angle) - x * math.sin(angle)])  # fmt: skip
    (a, b), radius = np.array(ends), math.hypot(0.08, 0.1)
    across = b - a
    half = np.linalg.norm(across) / 2
    down = np.array([-across[1], across[0]]) / (2 * half)
    return (a + b) / 2 + math.sqrt(radius**2 - half**2) * down * np.sign(-down[1])


def turned(point, angle):
    x, z = point
    return np.array([x * math.cos(angle) + z * math.sin(angle),
                     z * math.cos(angle) - x * math.sin(angle)])  # fmt: skip


def cylinder_tip(q):
    """Return the foot below the hip: the cylinder closes a triangle with the knee, (2,) m."""
    near, far, length = 0.07, math.hypot(0.05, 0.01), math.hypot(0.08, 0.05)

    def corner(side):
        return math.acos((near**2 + far**2 - side**2) / (2 * near * far))

    knee = corner(length) - corner(length + q[1])
    return turned((0, -THIGH), q[0]) + turned((0.06, -SHANK), q[0] + knee)


def finger_tip(q):
    """Return the foot below the hip: the springs share the tendon's length by cᵢ / kᵢ, (2,) m."""
    shares = np.array([0.02 / 1, -0.01 / 2])
    knee, ankle = shares * 0.02 * q[1] / (shares @ [0.02, -0.01])
    shank, foot = turned((0.04, -0.07), q[0] + knee), turned((-0.02, -0.05), q[0] + knee + ankle)
    return turned((-0.03, -0.08), q[0]) + shank + foot


CLOSED_FORMS = {
    "five_bar": five_bar_tip,
    # The rod keeps the shank parallel to the crank.
    "parallelogram": lambda q: turned((0, -THIGH), q[0]) + turned((0.03, -SHANK), q[1]),
    "driven_pogo": lambda q: turned((0, -THIGH - 0.06 + q[1]), q[0]),
    "linear_actuator": cylinder_tip,
    "tendon": finger_tip,
    "mimic": lambda q: turned((0.05, -THIGH), q[0]) + turned((-0.05, -SHANK), q[0] - 2 * q[0]),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_a_linkage_moves_as_in_closed_form(name, tmp_path):
    _, chain = chain_of(name, tmp_path)
    assert isinstance(chain, Linkage) == (name != "driven_pogo")
    rest, form = chain.place(chain.zero), CLOSED_FORMS[name]
    chance = np.random.default_rng(1)
    scale = np.where(chain.slides, 0.018, 0.5)
    angles = scale * chance.uniform(-1, 1, (40, len(chain.zero)))
    expected = np.array([form(one) - form(np.zeros(2)) for one in angles])
    moved = chain.place(angles) - rest
    np.testing.assert_allclose(moved[:, [0, 2]], expected, atol=1e-5)
    np.testing.assert_allclose(moved[:, 1], 0, atol=1e-9)
    # Angles of the foot's targets move it there.
    if len(chain.zero) == 2:
        found = chain.solve(chain.place(angles), chain.zero, chain.zero, chain.weights(False))
        np.testing.assert_allclose(chain.place(found), chain.place(angles), atol=2e-4)


def test_dependent_joints_close_a_linkage_in_mujoco(tmp_path):
    model, chain = chain_of("five_bar", tmp_path)
    data = mujoco.MjData(model)
    angles = np.array([0.3, -0.2])
    for leg in ("FL", "FR", "RL", "RR"):
        for joint, angle in zip(("a", "b"), angles, strict=True):
            data.qpos[model.joint(f"{leg}_{joint}").qposadr[0]] = angle
    data.qpos[chain.addresses] = chain.dependents(angles)
    mujoco.mj_kinematics(model, data)
    sites = model.eq_obj1id[0], model.eq_obj2id[0]
    assert np.linalg.norm(np.subtract(*data.site_xpos[[*sites]])) < 1e-6


def test_springs_keep_their_stiffness_and_are_relaxed_without_load(tmp_path):
    _, model, anatomy = read("spring_knee", tmp_path)
    knee = model.joint("FL_knee")
    assert model.jnt_stiffness[knee.id] == pytest.approx(4)
    assert anatomy.stance[knee.qposadr[0]] == pytest.approx(0.1)
    _, model, _ = read("pogo", tmp_path)
    slide = model.joint("FL_slide")
    assert model.jnt_type[slide.id] == mujoco.mjtJoint.mjJNT_SLIDE
    assert model.jnt_stiffness[slide.id] == pytest.approx(600)


def test_the_option_motors_answers_which_joints_are_driven(tmp_path):
    file, *_ = read("five_bar", tmp_path)
    front = tuple(f"{leg}_a" for leg in ("FL", "FR", "RL", "RR"))
    assert Robot(model=file.text, motors=front).anatomy.joints == front
    with pytest.raises(GaitsimError, match="FL_b"):
        Robot(model=file.text, motors=("FL_c",))
    pogo, *_ = read("pogo", tmp_path)
    legs = Robot(model=pogo.text, motors=("all",)).anatomy.legs
    assert legs[0].joints == ("FL_hip", "FL_slide")
    endless = pogo.text.replace('range="-0.05 0.05"', "")
    with pytest.raises(GaitsimError, match="slides without limits"):
        Robot(model=endless, motors=("FL_slide",))
    # A passive joint without limits gets some with its motor.
    mimic, *_ = read("mimic", tmp_path)
    model = compile_model(with_motors(mimic.text, ("FL_hip", "FL_knee")))
    assert model.joint("FL_knee").range == pytest.approx([-1.5708, 1.5708])
    assert model.nu == 2


def test_without_actuators_a_linkage_is_assumed_to_be_driven_at_the_trunk(tmp_path):
    path = mechanism("five_bar", tmp_path)
    text = path.read_text()
    path.write_text(text[: text.index("<actuator>")] + "</mujoco>")
    file = import_robot(path)
    assert find_anatomy(compile_model(file.text)).legs[0].joints == ("FL_a", "FL_b")
    (warning,) = file.warnings
    assert "organism.motors" in warning


def test_a_closed_linkage_walks_and_is_not_steered(tmp_path):
    file, *_ = read("five_bar", tmp_path)
    robot = Robot(model=file.text, duration=2.0, symmetry="alternating")
    start = robot.starts()["trot"][None]
    motion = robot.move(start)
    assert motion["torso"][0, -1, 0] > 0.05
    with pytest.raises(GaitsimError, match="closed linkages"):
        robot.pilot(start)


TAIL = (
    '<body name="tail" pos="-0.15 0 0"><joint name="wag" axis="0 0 1" range="-0.5 0.5" '
    'armature="5e-4"/><geom type="capsule" fromto="0 0 0 -0.1 0 0" size="0.01"/></body>'
)


def test_a_tail_swings_with_the_rhythm_if_asked(tmp_path):
    path = mechanism("toe", tmp_path, TAIL)
    text = path.read_text().replace("</actuator>", servo("wag") + "</actuator>")
    path.write_text(text)
    file = import_robot(path)
    still = Robot(model=file.text, duration=2.0, symmetry="alternating")
    assert still.anatomy.held == ("wag",)
    robot = still.model_copy(update={"swing": ("wag",)})
    assert (robot.anatomy.held, robot.anatomy.joints[-1]) == ((), "wag")
    names, space = still.genome_space().labels, robot.genome_space()
    assert space.labels == (*names, "wag swing", "wag swing phase")
    genome = robot.starts()["trot"]
    rest = robot.move(genome[None])
    assert np.ptp(rest["joint_angles"][0, :, -1]) == 0  # off in gaits made by hand
    genome[-2:] = 0.3, 0.5
    moved = robot.move(genome[None])["joint_angles"][0]
    np.testing.assert_array_equal(moved[:, :-1], rest["joint_angles"][0, :, :-1])
    time = np.arange(30, 101) / 50  # after the start
    frequency = rest[STRIDE_FREQUENCY][0]
    wave = 0.3 * np.sin(2 * np.pi * frequency * time + 0.5)
    np.testing.assert_allclose(moved[30:, -1], wave, atol=1e-6)
    with pytest.raises(GaitsimError, match="held joint 'FL_hip'"):
        Robot(model=file.text, swing=("FL_hip",))
    with pytest.raises(GaitsimError, match="spine, tail"):
        robot.pilot(genome[None])


def test_a_ball_turns_freely_and_has_no_motor(tmp_path):
    ball = (
        '<body name="b" pos="0 0 0.05"><joint name="neck" type="ball"/><geom size="0.01"/></body>'
    )
    _, model, anatomy = read("toe", tmp_path, ball)
    assert {"neck x", "neck y", "neck z"} <= {*anatomy.passive}
    axes = model.jnt_axis[[model.joint(f"neck {letter}").id for letter in "xyz"]]
    np.testing.assert_array_equal(axes, np.eye(3))
    path = mechanism("toe", tmp_path, ball)
    path.write_text(path.read_text().replace("</actuator>", '<motor joint="neck"/></actuator>'))
    with pytest.raises(GaitsimError, match="three hinges"):
        import_robot(path)


def test_a_tendon_pulls_as_its_spring(tmp_path):
    path = mechanism("toe", tmp_path)
    tendon = (
        '<tendon><fixed name="ham" stiffness="3" damping="0.2" springlength="0.1" '
        'range="-0.5 0.9"><joint joint="FL_hip" coef="1"/><joint joint="FL_knee" coef="-2"/>'
        '</fixed><fixed name="sensed"><joint joint="FR_hip" coef="1"/></fixed></tendon>'
    )
    path.write_text(path.read_text().replace("<actuator>", tendon + "<actuator>"))
    file = import_robot(path)
    assert not file.warnings  # a tendon without a spring changes nothing
    model = compile_model(file.text)
    data = mujoco.MjData(model)
    hip, knee = (model.joint(f"FL_{name}").qposadr[0] for name in ("hip", "knee"))
    data.qpos[[hip, knee]] = 0.4, -0.3
    mujoco.mj_forward(model, data)
    force = -3 * (0.4 + 2 * 0.3 - 0.1)
    assert data.qfrc_passive[[hip - 1, knee - 1]] == pytest.approx([force, -2 * force])
    assert model.tendon_range[0] == pytest.approx([-0.5, 0.9])
    pulled = path.read_text().replace("</actuator>", '<motor tendon="sensed"/></actuator>')
    path.write_text(pulled)  # FR_hip has a motor of its own
    with pytest.raises(GaitsimError, match=r"pull against each other.*'sensed"):
        import_robot(path)


def test_a_motor_that_pulls_a_tendon_flexes_its_joints_as_their_springs_allow(tmp_path):
    robot = Robot(model=read("tendon", tmp_path)[0].text, gravity=0.0)
    simulation = robot.simulation
    model, data = simulation.model, mujoco.MjData(simulation.model)
    mujoco.mj_setState(model, data, simulation.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    data.qpos[2] += 1
    data.ctrl[:] = 0
    data.ctrl[model.actuator("FL_flexor").id] = 0.6
    mujoco.mj_step(model, data, 1000)
    knee, ankle, pulley = (data.joint(f"FL_{one}").qpos[0] for one in ("knee", "ankle", "flexor"))
    assert pulley > 0.55
    assert [knee, ankle] == pytest.approx([8 / 9 * pulley, -2 / 9 * pulley], rel=0.01)
    # The servo has the file's stiffness: k · (command − length), with 0.02 m of length per radian.
    torque, length = data.actuator("FL_flexor").force[0], data.tendon("FL_flexor").length[0]
    assert torque == pytest.approx(0.02 * 8e4 * (0.02 * 0.6 - length), rel=1e-3)
    assert torque == pytest.approx(1 * knee, rel=1e-3)  # 1 N m/rad of the knee at an equal radius
    lost = Robot(model=robot.model, damage=("L1 lost",)).simulation.model
    assert lost.eq_active0.tolist() == [0, 1, 1, 1]


def test_tendons_couple_joints(tmp_path):
    path = mechanism("mimic", tmp_path)
    coupling = (
        '<equality><tendon tendon1="{0}_k" tendon2="{0}_h" polycoef="0 -2 0 0 0"/></equality>'
    )
    tendon = '<fixed name="{0}_{1}"><joint joint="{0}_{2}" coef="1"/></fixed>'
    text = path.read_text()
    legs = ("FL", "FR", "RL", "RR")
    ends = [tendon.format(leg, *end) for leg in legs for end in (("k", "knee"), ("h", "hip"))]
    text = re.sub("<equality>.*</equality>", "".join(map(coupling.format, legs)), text)
    path.write_text(text.replace("<tendon></tendon>", f"<tendon>{''.join(ends)}</tendon>", 1))
    model = compile_model(import_robot(path).text)
    chain = chain_of(path, tmp_path)[1]
    angles = np.linspace(-0.5, 0.5, 9)[:, None]
    np.testing.assert_allclose(chain.dependents(angles), -2 * angles, atol=1e-6)
    data = mujoco.MjData(model)
    model.opt.gravity[:] = 0
    data.qpos[model.joint("FL_hip").qposadr[0]] = 0.3
    mujoco.mj_step(model, data, 500)
    hip, knee = (data.joint(f"FL_{one}").qpos[0] for one in ("hip", "knee"))
    assert abs(hip) > 0.01
    assert knee == pytest.approx(-2 * hip, abs=1e-3)
    path.write_text(path.read_text().replace("0 -2 0", "0 -2 1"))
    (warning,) = import_robot(path).warnings
    assert "couplings by polynomials of tendons" in warning


def test_wheels_at_the_ends_of_legs_roll_if_asked(tmp_path):
    def wheeled(n, x, y):
        wheel = (
            f'<body name="{n}_wheel" pos="-0.05 0 {-SHANK}"><joint name="{n}_roll" '
            f'axis="0 {1 if y > 0 else -1} 0" armature="5e-4"/>'
            '<geom type="cylinder" euler="1.5708 0 0" size="0.03 0.01"/></body>'
        )
        bodies = two_links(n, x, y, hinge(f"{n}_knee"), wheel)
        return bodies, "", servo(f"{n}_hip", f"{n}_knee", f"{n}_roll")

    file = import_robot(mechanism(wheeled, tmp_path))
    held = Robot(model=file.text, duration=2.0)
    wheels = ("FL_roll", "FR_roll", "RL_roll", "RR_roll")
    assert (held.anatomy.wheels, held.anatomy.held) == (wheels, wheels)
    robot = Robot(model=file.text, duration=4.0, wheels="roll")
    assert robot.genome_space().labels == ("frequency", "roll")
    motion = robot.move(np.array([[1.0, 4.0]]))
    turned = motion["joint_positions"][0, -1, -4:]
    np.testing.assert_allclose(turned, 4 * 3.75 * np.array([1, -1, 1, -1]), atol=0.1)
    assert motion["torso"][0, -1, 0] == pytest.approx(0.03 * 4 * 3.75, rel=0.05)
    both = Robot(model=file.text, duration=2.0, wheels="both", symmetry="alternating")
    start = both.starts()["trot"]
    assert start[-1] == 0
    start[-1] = 3.0
    assert both.move(start[None])["torso"][0, -1, 0] > 0.05
    toe, *_ = read("toe", tmp_path)
    with pytest.raises(GaitsimError, match="wheel"):
        Robot(model=toe.text, wheels="roll")


def test_feet_that_no_motor_moves_are_refused(tmp_path):
    antenna = (
        '<body name="antenna" pos="0 0 0.05"><joint name="free" axis="0 1 0"/>'
        '<geom size="0.01"/></body>'
    )
    file, *_ = read("toe", tmp_path, antenna)
    with pytest.raises(GaitsimError, match="no joint with a motor moves antenna"):
        Robot(model=file.text, feet=("antenna",))
