"""Joints of legs that slide: units, servos, genes, files and refusals."""

import math
from xml.etree.ElementTree import fromstring, tostring

import mujoco
import numpy as np
import pytest
from mechanisms import driven_pogo, mechanism
from small_robots import dog_urdf

from gaitsim.gait.gait_files import Gait
from gaitsim.plugin import GaitsimError
from gaitsim_hardware.calibration import uniform_calibration
from gaitsim_hardware.keyframes import keyframes_of
from gaitsim_robot.importing import import_robot
from gaitsim_robot.organism import Robot
from gaitsim_robot.servos import joint_servos
from gaitsim_robot.text import compile_model

SLIDES = ("FL_slide", "FR_slide", "RL_slide", "RR_slide")


@pytest.fixture
def pogo(tmp_path):
    """Return the text of a robot with driven slides."""
    return import_robot(mechanism(driven_pogo, tmp_path)).text


def test_the_servos_of_slides_carry_the_weight_above_them(pogo):
    simulation = Robot(model=pogo).simulation
    model, data = simulation.model, mujoco.MjData(simulation.model)
    mujoco.mj_setState(model, data, simulation.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    data.ctrl[:] = simulation.rest
    mujoco.mj_step(model, data, 500)
    rods = sum(model.body(f"{name[:2]}_rod").mass[0] for name in SLIDES)
    ids = [model.actuator(name).id for name in SLIDES]
    force = data.actuator_force[ids]
    weight = 9.81 * (simulation.anatomy.mass - rods)
    assert -force.sum() == pytest.approx(weight * math.cos(data.qpos[7]), rel=0.01)
    short = (simulation.rest - data.qpos[7:])[ids]
    assert 2000 * short == pytest.approx(force, rel=0.01)  # k · Δ, with the file's stiffness


def test_limits_of_slides_are_forces_and_metres_per_second(pogo, tmp_path):
    def servo(text, **options):
        return joint_servos(compile_model(text), Robot(model=text).anatomy, **options)["FL_slide"]

    stated = servo(pogo, torque_limit=1.0, speed_limit=2.0, stiffness=3.0)
    assert (stated.stall_torque, stated.stiffness, stated.damping) == (60, 2000, 40)
    limits = 'range="-0.05 0.05" actuatorfrcrange="-60 60" user="0 2000 40"'
    assert limits in pogo
    bare = servo(pogo.replace(limits, 'range="-0.05 0.05"'))
    assert bare.stall_torque == pytest.approx(0.5 * 9.81 * Robot(model=pogo).anatomy.mass)
    assert "force assumed: 0.5 × weight" in bare.source
    huge = pogo.replace('actuatorfrcrange="-60 60"', 'actuatorfrcrange="-1e5 1e5"')
    assert "the file's 1e+05 N is a placeholder" in servo(huge).source
    with pytest.raises(GaitsimError, match="'mg995' turns joints, and the joint 'FL_slide' slides"):
        servo(pogo, name="mg995")
    facts = Robot(model=pogo).describe()
    assert "60 N, " in str(facts["Servos"])
    assert "0 mm (-50 to 50 mm)" in facts["Standing pose"]["L1"]


def test_a_prismatic_joint_keeps_effort_velocity_and_limits(tmp_path):
    robot = fromstring(dog_urdf())
    for joint in robot.iter("joint"):
        if "knee" in joint.get("name"):
            joint.set("type", "prismatic")
            limit = joint.find("limit")
            limit.attrib |= {"lower": "-0.02", "upper": "0.04", "effort": "80", "velocity": "0.3"}
    joint.remove(limit)
    path = tmp_path / "robot.urdf"
    path.write_bytes(tostring(robot))
    file = import_robot(path)
    (warning,) = file.warnings
    assert f"{joint.get('name')!r}; state the limits of slides" in warning
    for scale in (1.0, 0.5):
        model = compile_model(import_robot(path, scale=scale).text)
        (knee, *_) = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE)
        assert model.jnt_range[knee] == pytest.approx([-0.02 * scale, 0.04 * scale])
        assert model.jnt_actfrcrange[knee] == pytest.approx([-80, 80])
        assert model.jnt_user[knee, 0] == pytest.approx(0.3 * scale)


def test_genes_of_slides_are_shares_of_their_range(pogo):
    space = Robot(model=pogo, encoding="sine").genome_space()
    upper = dict(zip(space.labels, space.upper, strict=True))
    assert upper["FL_hip amplitude"] == pytest.approx(0.6)
    assert upper["FL_slide amplitude"] == pytest.approx(0.6 * 0.05)
    assert upper["FL_slide offset"] == pytest.approx(0.3 * 0.05)


def test_slides_of_mirrored_legs_move_alike(tmp_path):
    def aside(n, x, y):
        side = math.copysign(1, y)
        bodies, _, servos = driven_pogo(n, x, y)
        return bodies.replace('axis="0 0 1"', f'axis="0 {-side} 3"'), "", servos

    robot = Robot(model=import_robot(mechanism(aside, tmp_path)).text, symmetry="bound")
    angles = robot.move(robot.starts()["bound"][None])["joint_angles"][0]
    assert np.ptp(angles[:, 1]) > 0.005
    np.testing.assert_allclose(angles[:, :2], angles[:, 2:4], atol=1e-6)


def test_a_gait_of_slides_walks_and_what_only_turns_is_refused(pogo):
    robot = Robot(model=pogo, duration=2.0)
    start = robot.starts()["trot"]
    assert robot.move(start[None])["torso"][0, -1, 0] > 0.1
    assert robot.sliding_joints() == SLIDES
    assert robot.rig() is None
    with pytest.raises(GaitsimError, match="or slides"):
        robot.pilot(start[None])
    for options, match in (
        ({"damage": ("FL_slide stuck 20",)}, "cannot stick at an angle"),
        ({"horns": {"FL_slide": 1.0}}, "joint 'FL_slide'"),
        ({"stance": {"FL_slide": 0.06}}, "0.06 m of joint 'FL_slide'"),
    ):
        with pytest.raises(GaitsimError, match=match):
            Robot(model=pogo, **options)
    stuck = Robot(model=pogo, damage=("FL_slide stuck",), world={"joint_offset": 2.0})
    assert (stuck.simulation.offset[1::2] == 0).all()
    assert stuck.simulation.offset[::2].all()
    held = stuck.move(start[None])["joint_positions"][0, :, 1]
    assert np.ptp(held) < 1e-3
    raised = Robot(model=pogo, stance=dict.fromkeys(SLIDES, 0.01))
    assert (raised.standing_pose()[1::2] == 0.01).all()
    gait = Gait(np.zeros((2, 1)), ("slide",), 50.0, 0, 0.0, None, ("slide",))
    with pytest.raises(GaitsimError, match="'slide' slides"):
        keyframes_of(gait, uniform_calibration(gait.joint_names, 0, -90, 90))
