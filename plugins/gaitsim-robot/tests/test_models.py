"""The bundled robots have the properties that the comments in their files state."""

from copy import copy
from pathlib import Path

import mujoco
import numpy as np
import pytest
import rigid_body
from rigid_body import replay

import gaitsim
import gaitsim_robot
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait import compare_bodies, play_on_twin
from gaitsim.gait.gait_files import play_gait, read_gait
from gaitsim_spider import body

MODELS = {
    path.stem: mujoco.MjModel.from_xml_path(str(path))
    for path in (Path(gaitsim_robot.__file__).parent / "models").glob("*.xml")
}


def placed(model, qpos):
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    return data


def feet(model):
    return [geom for geom in range(model.ngeom) if model.geom(geom).name.endswith("foot")]


@pytest.mark.parametrize(
    ("name", "mass", "legs", "joints"),
    [("quadruped", 1.7, 4, 12), ("hexapod", 1.87, 6, 18), ("spider-physics", 1.2, 8, 24)],
)
def test_a_bundled_robot_stands_level_on_all_its_feet(name, mass, legs, joints):
    model = MODELS[name]
    data = placed(model, model.key("stand").qpos)
    soles = data.geom_xpos[feet(model)] - [
        [0, 0, radius] for radius in model.geom_size[feet(model), 0]
    ]
    assert (len(soles), model.njnt) == (legs, joints + 1)
    assert model.body_mass.sum() == pytest.approx(mass)
    np.testing.assert_allclose(soles[:, 2], 0.0, atol=2e-5)
    np.testing.assert_allclose(soles.mean(axis=0)[:2], data.subtree_com[1, :2], atol=0.01)
    within = model.key("stand").qpos[7:, None] - model.jnt_range[1:]
    assert (within[:, 0] > 0.3).all()
    assert (within[:, 1] < -0.3).all()
    assert (model.jnt_user[1:, 0] > 5).all()
    assert model.jnt_actfrclimited[1:].all()


@pytest.mark.parametrize("name", MODELS)
def test_the_sides_of_a_bundled_robot_mirror_each_other(name):
    model = MODELS[name]
    for left in range(2, model.nbody):
        if (part := model.body(left).name).startswith("L"):
            right = model.body("R" + part[1:]).id
            for kind in (model.body_mass, model.body_inertia):
                np.testing.assert_allclose(kind[left], kind[right])
            data = placed(model, model.key("stand").qpos)
            np.testing.assert_allclose(data.xipos[left], data.xipos[right] * [1, -1, 1], atol=2e-5)


def test_the_physics_twin_has_the_joints_limits_and_masses_of_the_spider():
    twin = MODELS["spider-physics"]
    assert tuple(twin.joint(joint).name for joint in range(1, twin.njnt)) == body.JOINTS
    np.testing.assert_allclose(np.abs(twin.jnt_range[1:]), body.ANGLE_LIMIT, atol=1e-5)
    for leg in body.LEGS:
        assert [twin.body(f"{leg} {segment}").mass[0] for segment in body.SEGMENTS] == [
            body.COXA_MASS,
            body.FEMUR_MASS,
            body.TIBIA_MASS,
        ]


def test_the_physics_twin_has_the_feet_of_the_independent_model():
    twin, rng = MODELS["spider-physics"], np.random.default_rng(0)
    poses = rng.uniform(-body.ANGLE_LIMIT, body.ANGLE_LIMIT, (20, 24))
    at_origin = [placed(twin, [0, 0, 0, 1, 0, 0, 0, *pose]) for pose in poses]
    np.testing.assert_allclose(
        [data.geom_xpos[feet(twin)] for data in at_origin], rigid_body.feet(poses), atol=5e-5
    )


def test_the_physics_twin_has_the_inertia_of_the_independent_model():
    reference, twin = copy(rigid_body._model()), MODELS["spider-physics"]
    reference.dof_armature[:] = 0.0
    pose = np.random.default_rng(1).uniform(-0.5, 0.5, 24)

    def inertia(model):
        data = placed(model, [0, 0, 0, 1, 0, 0, 0, *pose])
        full = np.empty((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        return full

    np.testing.assert_allclose(inertia(twin), inertia(reference), rtol=2e-3, atol=2e-6)


GAITS = Path(__file__).parents[3] / "data/gaits"


@pytest.mark.parametrize("gait", ["alternating-tetrapod", "ripple"])
def test_a_gait_walks_as_far_on_the_twin_as_in_the_independent_simulation(gait):
    file = read_gait(GAITS / f"{gait}.npz")
    individual = play_gait(file, load_experiment("spider"))
    twin = play_on_twin(individual)
    reference = replay(individual.joint_angles)
    assert twin.measures["forward"] == pytest.approx(reference.forward, rel=0.12)
    assert abs(twin.measures["yaw"] - reference.yaw) < 5
    assert twin.measures["lasted"] == pytest.approx(9.96)
    found = {one.name: one for one in compare_bodies(individual, twin)}
    forward = found["forward"]
    assert forward.own == pytest.approx(individual.measures["forward"])
    assert (forward.other, forward.unit) == (pytest.approx(twin.measures["forward"]), "m")
    assert np.isnan(found["peak torque"].own)


def test_a_body_without_a_twin_is_refused():
    twin = play_on_twin(play_gait(read_gait(GAITS / "ripple.npz"), load_experiment("spider")))
    with pytest.raises(GaitsimError, match="has no twin in rigid-body physics"):
        play_on_twin(twin)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["quadruped", "hexapod", "spider-physics"])
def test_three_generations_find_a_walk_without_a_fall(preset):
    search = gaitsim.evolve(preset, generations=3, workers=1)
    assert [*search]
    found = search.champion.measures
    assert found["lasted"] == 10.0
    assert found["body lengths"] > 5
    assert abs(found["yaw"]) < 30
