"""The robot's skeleton, against the positions of geoms, joints and feet in MuJoCo."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
import small_robots
from scipy.spatial.transform import Rotation

from gaitsim.contracts import Motion
from gaitsim.experiment import load_experiment
from gaitsim.tui.screens.presets import draw_body
from gaitsim_robot.figure import figure
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.organism import BUNDLED, Robot
from gaitsim_robot.skeleton import skeleton

START = np.array([0.25, -0.5, 0.0])


def drawn(model, anatomy, configuration, start):
    """Return the skeleton of a robot in the given configurations, (frames, nq)."""
    simulation = SimpleNamespace(
        model=model, anatomy=anatomy, damage=(), start=[0.0, *start], ground=None, world={}
    )
    touching = np.ones((1, len(configuration), len(anatomy.legs)), bool)
    motion = Motion(50.0, {"configuration": configuration[None], "stance": touching})
    return skeleton(simulation, motion, 0)


@pytest.fixture(params=BUNDLED)
def model(request):
    return mujoco.MjModel.from_xml_string(Robot(model=request.param).text)


def test_solids_segments_and_feet_have_the_positions_of_mujoco(model):
    anatomy = find_anatomy(model)
    rng = np.random.default_rng(1)
    configuration = np.repeat(anatomy.stance[None], 3, axis=0)
    configuration[1:, 7:] += rng.normal(0, 0.3, (2, model.nq - 7))
    configuration[2, 3:7] = Rotation.from_euler("xyz", [0.3, -0.4, 2.0]).as_quat()[[3, 0, 1, 2]]
    image = drawn(model, anatomy, configuration, START)
    assert len(image.solids) == model.ngeom
    assert np.ptp(np.linalg.norm(np.diff(image.segments, axis=2), axis=-1), axis=0).max() < 1e-9
    data = mujoco.MjData(model)
    for frame, positions in enumerate(configuration):
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        assert np.allclose(image.poses[frame, :, :3], data.geom_xpos - START)
        turned = Rotation.from_quat(image.poses[frame, :, [4, 5, 6, 3]].T).as_matrix()
        assert np.allclose(turned.reshape(-1, 9), data.geom_xmat, atol=1e-6)
        ends = image.segments[frame].reshape(-1, 3) + START
        for joint in range(1, model.njnt):
            anchor = data.xanchor[joint]
            assert np.linalg.norm(ends - anchor, axis=1).min() < 0.011 * anatomy.length
        for leg, foot in zip(anatomy.legs, image.contacts[frame], strict=True):
            assert np.linalg.norm(image.segments[frame] - foot, axis=-1).min() < 1e-9
            there = data.body(leg.foot).xpos + data.body(leg.foot).xmat.reshape(3, 3) @ leg.point
            assert np.allclose(foot + START, there)
    for leg in anatomy.legs:
        assert any(name.startswith(f"{leg.name} ") for name in image.names)
        assert any(solid.name.startswith(f"{leg.name} ") for solid in image.solids)


def test_a_limb_without_geoms_is_a_rod_from_joint_to_joint():
    model = mujoco.MjModel.from_xml_string(Robot(model="quadruped").text)
    anatomy = find_anatomy(model)
    thigh = model.body("L1 thigh").id
    model.geom_bodyid[model.geom_bodyid == thigh] = 0  # geoms of the world are not drawn
    image = drawn(model, anatomy, anatomy.stance[None], np.zeros(3))
    (rod,) = (i for i, solid in enumerate(image.solids) if solid.name == "L1 thigh")
    ends = image.segments[0, image.names.index("L1 thigh")]
    assert np.allclose(image.poses[0, rod, :3], ends.mean(axis=0))
    x, y, z = Rotation.from_quat(image.poses[0, rod, [4, 5, 6, 3]]).as_matrix()[:, 2]
    assert np.allclose((x, y, z), (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))
    assert 2 * sum(image.solids[rod].size) == pytest.approx(np.linalg.norm(ends[1] - ends[0]))


def test_vertebrae_are_not_drawn_as_a_left_leg_because_of_their_names():
    front, rear = (
        [small_robots.leg(f"{end}{side}", 0, y) for side, y in (("L", 0.1), ("R", -0.1))]
        for end in "FR"
    )
    spine = '<body name="L_1" pos="-0.4 0 0"><joint name="bend" axis="0 0 1" range="-1 1"/>'
    trunk, pelvis = (small_robots.box(length, 0.16, 0.1, 3) for length in (0.4, 0.25))
    text = small_robots.robot(trunk, *front, spine, pelvis, *rear, "</body>")
    model = mujoco.MjModel.from_xml_string(text)
    anatomy = find_anatomy(model)
    assert anatomy.held == ("bend",)
    drawing = figure(model, anatomy)
    for names in (drawing.names, [solid.name for solid in drawing.solids]):
        assert "spine L_1" in names
        assert "L_1" not in names


def test_passive_joints_are_placed_where_the_standing_robot_has_them(tmp_path):
    text = small_robots.QUADRUPED
    driven = [
        f"{leg}_{joint}" for leg in small_robots.CORNERS for joint in ("roll", "pitch", "knee")
    ]
    motors = "".join(f'<motor joint="{name}"/>' for name in driven)
    path = tmp_path / "robot.xml"
    path.write_text(text.replace("</mujoco>", f"<actuator>{motors}</actuator></mujoco>"))
    experiment = load_experiment(str(path))
    robot = experiment.organism
    assert robot.anatomy.passive == ("turn", "raise")
    picture = draw_body(experiment, (60, 20), named=True)
    assert {name for name in ("L1", "R1", "L2", "R2", "front") if name in picture} == {
        *robot.leg_joints(), "front"
    }  # fmt: skip
    assert "○" in picture
    plain = draw_body(experiment, (60, 20))
    assert "○" not in plain
    assert "front" not in plain
    places, height = robot.passive_places(), robot.anatomy.stance[2]
    assert places[0] == pytest.approx([0.1, 0, height + 0.06], abs=0.02)
