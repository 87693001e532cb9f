"""The physics of robots against closed forms."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_robots import FACING_Y
from stick import quadruped_spec, simulation_of, standing_quadruped, trot

from gaitsim.contracts.quaternions import conjugate, product
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import orientation, walk
from gaitsim_robot.terrain import GROUND

FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
GRAVITY = 9.81


def started(simulation):
    data = mujoco.MjData(simulation.model)
    mujoco.mj_setState(simulation.model, data, simulation.start, FULL)
    data.ctrl[:] = simulation.rest
    mujoco.mj_forward(simulation.model, data)
    return data


def energies(model, data):
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return data.energy.sum()


def servo_work(model, data, steps):
    """Return the signed work of all servos, from the mean speed in each step."""
    work = 0.0
    for _ in range(steps):
        before = data.actuator_velocity.copy()
        mujoco.mj_step(model, data)
        after = data.qvel[6:]
        work += (data.actuator_force * (before + after)).sum() / 2 * model.opt.timestep
    mujoco.mj_forward(model, data)
    return work


def test_at_rest_the_feet_carry_the_weight():
    simulation, _ = standing_quadruped("sts3215")
    rest = np.repeat(simulation.rest[simulation.ctrl][None, None], 251, axis=1)
    motion = walk(simulation, rest)
    load = motion["load"][0, -1, :, 2].sum()
    assert load == pytest.approx(simulation.anatomy.mass * GRAVITY, rel=0.01)
    assert np.abs(motion["foot_positions"][0, :, :, 2]).max() < 1e-3
    assert np.linalg.norm(motion["torso"][0, -1] - motion["torso"][0, 0]) < 5e-4


def test_without_contact_the_work_of_the_servos_equals_the_gain_in_energy():
    simulation, _ = standing_quadruped("sts3215", dt=5e-4)
    data = started(simulation)
    data.qpos[2] += 10.0
    mujoco.mj_forward(simulation.model, data)
    before = energies(simulation.model, data)
    data.ctrl[:] = np.linspace(-0.5, 0.9, len(data.ctrl))
    work = servo_work(simulation.model, data, 200)
    gain = energies(simulation.model, data) - before
    assert data.ncon == 0
    assert gain == pytest.approx(work, rel=0.02)
    assert gain > 0.1


def test_a_rising_robot_gains_the_work_of_its_servos_minus_the_loss_in_contacts():
    # With steps of 1 ms, the error of integration exceeds the small loss of feet that hardly slip.
    simulation, _ = standing_quadruped("sts3215", dt=2.5e-4)
    data = started(simulation)
    data.ctrl[:] = simulation.rest
    before, height = energies(simulation.model, data), data.subtree_com[1, 2]
    lower, _ = simulation.model.actuator_ctrlrange.T
    knees = np.array([name.endswith("knee") for name in simulation.anatomy.joints])
    data.ctrl[simulation.ctrl[knees]] += 0.5
    data.ctrl[simulation.ctrl[np.roll(knees, -1)]] -= 0.25
    assert (data.ctrl > lower).all()
    work = servo_work(simulation.model, data, 8000)
    mujoco.mj_comPos(simulation.model, data)
    rise = simulation.anatomy.mass * GRAVITY * (data.subtree_com[1, 2] - height)
    gain = energies(simulation.model, data) - before
    assert gain == pytest.approx(rise, rel=0.01)
    assert rise > 0.2
    assert 0 < work - gain < 0.3 * work


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_feet_that_slide_decelerate_a_robot_by_coulomb_friction(friction):
    simulation, _ = standing_quadruped("ideal", friction=friction)
    data = started(simulation)
    data.qvel[0] = 3.0
    mujoco.mj_step(simulation.model, data)
    start, speed = data.time, com_speed(simulation.model, data)
    mujoco.mj_step(simulation.model, data, 100)
    lost = speed - com_speed(simulation.model, data)
    assert lost == pytest.approx(friction * GRAVITY * (data.time - start), rel=0.02)


def com_speed(model, data):
    mujoco.mj_subtreeVel(model, data)
    return data.subtree_linvel[1, 0]


def test_halving_the_time_step_changes_the_distance_of_a_trot_by_less_than_a_tenth():
    far = []
    for dt in (0.004, 0.002):
        simulation, _ = standing_quadruped("sts3215", dt=dt)
        motion = walk(simulation, trot(simulation, 251))
        assert motion["lasted"] == 5.0
        far.append(motion["torso"][0, -1, 0])
    assert far[0] > 0.8
    assert far[1] == pytest.approx(far[0], rel=0.1)


def test_work_is_torque_times_speed_and_rms_torque_counts_every_step():
    simulation, _ = standing_quadruped("sts3215", dt=0.002, latency=0)
    commands = trot(simulation, 101)
    motion = walk(simulation, commands)
    data, work, squares = started(simulation), 0.0, 0.0
    for frame in commands[0, :-1]:
        data.ctrl[simulation.ctrl] = frame
        for _ in range(simulation.steps):
            mujoco.mj_forward(simulation.model, data)
            work += np.abs(data.actuator_force * data.actuator_velocity).sum() * 0.002
            squares += data.actuator_force[simulation.ctrl] ** 2
            mujoco.mj_step(simulation.model, data)
    assert motion["energy"][0, -1] == pytest.approx(work, rel=1e-3)
    rms = np.sqrt(squares / (100 * simulation.steps))
    assert motion["rms_torque"][0] == pytest.approx(rms, rel=1e-3)
    assert motion["continuous_torque"][0] == pytest.approx(motion["stall_torque"][0] / 5)


def test_an_unstable_robot_fails_without_affecting_others_or_writing_files(
    tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    robot = Robot(
        servo="sts3215", dt=0.01, stiffness=1e6, torque_limit=1e5, speed_limit=100, latency=0
    )
    simulation = robot.simulation
    rest = np.repeat(simulation.rest[simulation.ctrl][None, None], 101, axis=1)
    wild = rest.copy()
    wild[0, 60::2] += 0.5
    motion = robot.play(np.concatenate([rest, wild, rest]))
    assert list(motion.failures) == [1]
    assert "unstable after 1." in motion.failures[1]
    alone = robot.play(rest)
    for name in motion:
        assert np.isfinite(motion[name]).all()
        np.testing.assert_array_equal(motion[name][[0, 2]], np.repeat(alone[name], 2, axis=0))
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_bodies_that_overlap_in_the_standing_pose_never_collide_and_others_do():
    spec = quadruped_spec()
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 1
        if geom.name.endswith("thigh"):
            geom.size[0] = 0.03
    simulation, _ = simulation_of(spec, "sts3215")
    data = started(simulation)
    assert simulation.stands
    assert {contact.geom1 for contact in data.contact} <= {simulation.model.geom(GROUND).id}
    thighs = [simulation.model.joint(f"{side}1 hip roll").qposadr[0] for side in "LR"]
    data.qpos[thighs] = [-0.8, 0.8]
    mujoco.mj_forward(simulation.model, data)
    touching = {simulation.model.geom(contact.geom1).name for contact in data.contact}
    assert any(name.endswith(("thigh", "shank")) for name in touching)


def test_a_robot_too_weak_to_stand_starts_in_its_pose_and_reports_the_torque_needed():
    strong, _ = standing_quadruped("sts3215")
    weak, _ = standing_quadruped("sts3215", torque_limit=0.1)
    assert strong.stands
    assert not weak.stands
    np.testing.assert_array_equal(weak.start[1 : 1 + len(weak.anatomy.stance)], weak.anatomy.stance)
    assert strong.effort.max() < 0.5
    assert weak.effort.max() > 1
    np.testing.assert_allclose(0.1 * weak.effort, 1.912 * strong.effort, atol=0.1)


def test_orientation_is_relative_to_the_standing_pose():
    upright = Rotation.from_euler("zyx", [0.4, -1.1, 1.5])
    angles = np.array([[0.1, -0.2, 0.3], [0.5, 0.4, -1.2], [-0.3, 0.9, -0.4]])  # roll, pitch, yaw
    turned = Rotation.from_euler("ZYX", angles[:, ::-1]) * upright
    trunk, standing = (np.roll(turn.as_quat(), 1, axis=-1) for turn in (turned, upright))
    found = orientation(product(trunk, conjugate(standing))[None])
    assert found[0] == pytest.approx(angles, abs=1e-12)


def test_a_robot_that_faces_y_in_its_file_stands_upright():
    simulation, _ = simulation_of(mujoco.MjSpec.from_string(FACING_Y), "model")
    motion = walk(simulation, np.repeat(simulation.rest[simulation.ctrl][None, None], 101, axis=1))
    assert simulation.stands
    assert motion["lasted"][0] == 2.0
    assert np.abs(motion["orientation"]).max() < 0.05
