"""Robots written as URDF, and read again."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gaitsim_robot.organism import Robot
from gaitsim_robot.text import compile_model
from gaitsim_robot.urdf import angles


def reread(robot, folder, **options):
    """Return the robot of a robot's URDF."""
    path = folder / "robot.urdf"
    path.write_text(robot.urdf())
    return Robot(model=str(path), **options)


@pytest.mark.sampled
@pytest.mark.parametrize("name", ["quadruped", "hexapod", "spider-physics"])
def test_a_bundled_robot_is_the_same_after_its_urdf(tmp_path, name):
    robot = Robot(model=name)
    again = reread(robot, tmp_path)
    assert again.joint_names() == robot.joint_names()
    assert again.leg_joints() == robot.leg_joints()
    assert again.anatomy.mass == pytest.approx(robot.anatomy.mass, rel=1e-6)
    poses = np.random.default_rng(1).uniform(-0.6, 0.6, (20, len(robot.joint_names())))
    feet, same = robot.rig().place(poses).feet, again.rig().place(poses).feet
    assert np.ptp(feet, axis=0).max() > 0.05
    # The contact points depend on the shapes, the places of the feet do not.
    assert same - same[:1] == pytest.approx(feet - feet[:1], abs=0.005)


def mass_matrix(robot, pose):
    """Return the mass matrix of a robot at a pose of its leg joints."""
    import mujoco

    model = compile_model(robot.text)
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    for name, angle in zip(robot.joint_names(), pose, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    for row, unit in zip(matrix, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, row, unit)
    return matrix - np.diag(model.dof_armature)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["quadruped", "hexapod", "spider-physics"])
def test_masses_and_inertias_are_the_same(tmp_path, name):
    robot = Robot(model=name)
    pose = np.random.default_rng(2).uniform(-0.5, 0.5, len(robot.joint_names()))
    expected = mass_matrix(robot, pose)
    again = mass_matrix(reread(robot, tmp_path), pose)
    assert again == pytest.approx(expected, rel=1e-5, abs=1e-8)


@pytest.mark.slow
def test_a_robot_that_faces_another_way_faces_forward_in_its_urdf(tmp_path):
    robot = Robot(model="quadruped", facing="-x")
    again = reread(robot, tmp_path, facing="+x")
    assert again.leg_joints() == robot.leg_joints()
    poses = np.random.default_rng(3).uniform(-0.5, 0.5, (2, len(robot.joint_names())))
    feet, same = robot.rig().place(poses).feet, again.rig().place(poses).feet
    assert same == pytest.approx(feet, abs=0.01)


@pytest.mark.slow
def test_a_robot_read_from_its_urdf_walks(tmp_path):
    robot = Robot(model="hexapod", duration=4.0)
    genome = next(iter(robot.starts().values()))
    moved = robot.move(genome[None])
    played = reread(robot, tmp_path, duration=4.0).play(moved["joint_angles"])
    distance, same = (one["torso"][0, -1, 0] for one in (moved, played))
    assert distance > 0.5
    assert same == pytest.approx(distance, rel=0.3)


def test_angles_are_those_of_scipy_and_hold_at_right_angles():
    turns = Rotation.random(200, rng=np.random.default_rng(2))
    steep = Rotation.from_euler("xyz", [[0.3, one * np.pi / 2, 0.9] for one in (-1, 1)])
    for turn in (*turns, *steep):
        found = angles(np.roll(turn.as_quat(), 1))
        error = Rotation.from_euler("xyz", found) * turn.inv()
        assert error.magnitude() < 1e-6
