"""The second engine, PyBullet, against MuJoCo and closed forms."""

import sys
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from stick import simulation_of, standing_quadruped, trot

from gaitsim.registry import ENGINES, entries
from gaitsim_bullet.body import BulletBody
from gaitsim_bullet.client import open_client
from gaitsim_bullet.rollout import Drives, roll_out
from gaitsim_robot.errors import RobotError
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import walk
from gaitsim_robot.terrain import GROUND

GRAVITY = 9.81
FRAMES = 51


@pytest.fixture
def bullet():
    pytest.importorskip("pybullet")


@pytest.fixture
def simulation():
    return standing_quadruped("sts3215")[0]


def rest(simulation, frames=FRAMES):
    return np.tile(simulation.rest[simulation.ctrl], (1, frames, 1))


def centre_of_mass(body):
    """Return the centre of mass, (3,) m."""
    data = mujoco.MjData(body.model)
    data.qpos[:] = body.state()[0]
    mujoco.mj_kinematics(body.model, data)
    mujoco.mj_comPos(body.model, data)
    return data.subtree_com[1].copy()


def velocity_of_centre(body):
    """Return the velocity of the centre of mass, (3,) m/s."""
    data = mujoco.MjData(body.model)
    data.qpos[:], data.qvel[:] = body.state()
    mujoco.mj_fwdPosition(body.model, data)
    mujoco.mj_fwdVelocity(body.model, data)
    mujoco.mj_subtreeVel(body.model, data)
    return data.subtree_linvel[1].copy()


@pytest.mark.parametrize("name", ["quadruped", "spider-physics"])
def test_masses_inertias_and_frames_equal_those_of_the_compiled_robot(bullet, name):
    simulation = Robot(model=name).simulation
    model = simulation.model
    data = mujoco.MjData(model)
    data.qpos[:] = simulation.start[1 : 1 + model.nq]
    mujoco.mj_forward(model, data)
    with open_client(0.002) as client:
        body = BulletBody(client, simulation)
        np.testing.assert_allclose(body.state()[0], data.qpos, atol=1e-12)
        for index, link in enumerate(body.links):
            if link.body < 0:
                continue
            mass, _, inertia, *_ = client.getDynamicsInfo(body.number, index)
            place, turn, *_ = client.getLinkState(body.number, index, computeForwardKinematics=1)
            assert mass == model.body_mass[link.body]
            np.testing.assert_allclose(inertia, model.body_inertia[link.body], rtol=1e-12)
            np.testing.assert_allclose(place, data.xipos[link.body], atol=1e-9)
            frame = np.reshape(client.getMatrixFromQuaternion(turn), (3, 3))
            np.testing.assert_allclose(frame, data.ximat[link.body].reshape(3, 3), atol=1e-9)
        found = client.getDynamicsInfo(body.number, -1)
        assert (found[0], *found[2]) == (model.body_mass[1], *model.body_inertia[1])


@pytest.mark.parametrize("servo", ["sts3215", "model", "ideal"])
def test_servos_have_the_torques_of_mujocos_actuators(servo):
    simulation, _ = standing_quadruped(servo)
    model, data = simulation.model, mujoco.MjData(simulation.model)
    drives, random = Drives(model, np.arange(1, model.njnt)), np.random.default_rng(0)
    shares = []
    for _ in range(100):
        data.qpos[:] = simulation.start[1 : 1 + model.nq]
        data.ctrl[:] = simulation.rest + random.uniform(-0.5, 0.5, model.nu)
        data.qvel[6:] = random.uniform(-2, 2, model.nu) * simulation.top_speed.max()
        mujoco.mj_forward(model, data)
        servos, every = drives.torques(data.ctrl, data.qpos[7:], data.qvel[6:])
        np.testing.assert_allclose(servos, data.qfrc_actuator[6:], atol=1e-9)
        np.testing.assert_allclose(every, (data.qfrc_actuator + data.qfrc_passive)[6:], atol=1e-9)
        shares.append(np.abs(servos) / simulation.stall_torque.max())
    assert np.ptp(shares) > 0.99


def test_a_falling_robot_moves_its_joints_as_in_mujoco(bullet):
    dt, steps = 1e-4, 2000
    simulation, _ = standing_quadruped("sts3215", dt=dt)
    model, data = simulation.model, mujoco.MjData(simulation.model)
    simulation.start[3] += 10
    data.qpos[:] = simulation.start[1 : 1 + model.nq]
    data.ctrl[:] = simulation.rest + np.linspace(-0.3, 0.3, model.nu)
    drives = Drives(model, np.arange(1, model.njnt))
    with open_client(dt) as client:
        body = BulletBody(client, simulation)
        first = centre_of_mass(body)
        for _ in range(steps):
            _, torque = drives.torques(data.ctrl, *body.angles())
            body.step(torque)
        fallen, (qpos, qvel) = first - centre_of_mass(body), body.state()
    mujoco.mj_step(model, data, steps)
    np.testing.assert_allclose(fallen, [0, 0, GRAVITY * (steps * dt) ** 2 / 2], atol=2e-4)
    moved = np.abs(data.qpos[7:] - simulation.start[8 : 1 + model.nq]).max()
    assert moved > 0.2
    np.testing.assert_allclose(qpos[7:], data.qpos[7:], atol=0.01 * moved)
    np.testing.assert_allclose(qpos[3:7], data.qpos[3:7], atol=0.01 * moved)
    np.testing.assert_allclose(qvel[6:], data.qvel[6:], atol=0.01 * np.abs(data.qvel[6:]).max())


def test_at_rest_the_ground_carries_the_weight_and_servos_sag_as_in_mujoco(bullet, simulation):
    motion = walk(simulation, rest(simulation), roll_out)
    weight = simulation.anatomy.mass * GRAVITY
    assert motion["load"][0, -1, :, 2].sum() == pytest.approx(weight, rel=1e-3)
    assert motion["lasted"][0] == 1.0
    sag = rest(simulation)[0, 0] - motion["joint_positions"][0, -1]
    expected = rest(simulation)[0, 0] - simulation.start[1 + simulation.qpos]
    np.testing.assert_allclose(sag, expected, atol=2e-3)
    assert np.abs(motion["torso"][0, -1] - motion["torso"][0, 0]).max() < 1e-3
    assert np.abs(motion["foot_positions"][0, :, :, 2]).max() < 2e-3


@pytest.mark.parametrize("direction", [0.0, 60.0, 200.0])
def test_the_feet_of_a_sliding_robot_have_the_nominal_friction_against_the_slip(bullet, direction):
    simulation, dt, steps = Robot(model="hexapod", servo="ideal").simulation, 0.002, 50
    angle = np.radians(direction)
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    speeds = []
    with open_client(dt) as client:
        body = BulletBody(client, simulation)
        drives = Drives(body.model, body.joints)
        client.resetBaseVelocity(body.number, (2 * along).tolist(), [0.0, 0.0, 0.0])
        for _ in range(2 * steps):
            body.step(drives.torques(simulation.rest, *body.angles())[1])
            speeds.append(velocity_of_centre(body))
    impulse = speeds[-1] - speeds[steps - 1] + np.array([0.0, 0.0, GRAVITY * steps * dt])
    friction = simulation.model.geom(GROUND).friction[0]
    found = impulse / impulse[2]
    np.testing.assert_allclose(found[:2], -friction * along[:2], atol=0.05 * friction)


def test_friction_holds_a_robot_on_a_slope(bullet):
    world = {"slope": 20.0, "side_slope": -20.0}
    simulation = Robot(model="hexapod", servo="ideal", world=world).simulation
    feet = walk(simulation, rest(simulation), roll_out)["foot_positions"][0]
    assert np.abs(feet[-1] - feet[1])[:, :2].max() < 1e-3


@pytest.mark.slow
def test_a_trot_resembles_that_in_mujoco_and_has_the_same_bits_alone_and_in_threads(
    bullet, simulation
):
    commands = np.repeat(trot(simulation, 101), 2, axis=0)
    commands[1, 20:, 0] += 3.0
    together = walk(simulation, commands, roll_out)
    other = walk(simulation, commands)
    far, as_far = (motion["torso"][0, -1, 0] for motion in (together, other))
    assert far == pytest.approx(as_far, rel=0.3)
    assert far > 0.2
    assert together["energy"][0, -1] == pytest.approx(other["energy"][0, -1], rel=0.2)
    with ThreadPoolExecutor(2) as threads:
        play = [commands[[1]], commands[[0]]]
        second, first = threads.map(lambda one: walk(simulation, one, roll_out), play)
    for name in together:
        np.testing.assert_array_equal(np.concatenate([first[name], second[name]]), together[name])


def test_a_stuck_joint_does_not_move_and_a_lost_leg_carries_no_load(bullet):
    robot = Robot(damage=("L1 lost", "R2 knee stuck -60"), duration=0.5, engine="bullet")
    simulation = robot.simulation
    angles = np.tile(simulation.rest[simulation.ctrl], (1, 11, 1))
    motion = robot.play(angles)
    stuck = robot.joint_names().index("R2 knee")
    np.testing.assert_allclose(motion["joint_positions"][0, :, stuck], np.radians(-60), atol=1e-3)
    assert not motion["load"][0, :, 0].any()
    assert motion["load"][0, :, 1:].any()


def test_the_engine_prints_nothing(bullet, capfd, simulation):
    walk(simulation, rest(simulation, 3), roll_out)
    assert capfd.readouterr() == ("", "")


def test_the_error_for_a_missing_pybullet_shows_how_to_install_it(monkeypatch):
    if "bullet" not in entries(ENGINES):
        pytest.skip("gaitsim-bullet is not installed")
    monkeypatch.setitem(sys.modules, "pybullet", None)
    robot = Robot(engine="bullet")
    with pytest.raises(RobotError, match="PyBullet is not installed") as raised:
        robot.play(np.zeros((1, 2, 12)))
    assert "pip install pybullet" in raised.value.remedy
    assert not robot.threads
    assert Robot().threads


def test_robots_with_parts_that_bullet_does_not_simulate_are_refused(bullet):
    spec = mujoco.MjSpec.from_string(Robot().text)
    mimic = spec.add_equality(name1="L1 knee", name2="R1 knee")
    mimic.type, mimic.objtype = mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtObj.mjOBJ_JOINT
    simulation, _ = simulation_of(spec, "sts3215")
    with pytest.raises(RobotError, match="does not simulate mimic joints"):
        walk(simulation, rest(simulation, 3), roll_out)
