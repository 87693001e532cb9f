"""URDF and MJCF files of our own become the robot's text; hostile ones one message."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from gaitsim_robot.importing.convert import convert

FIXTURES = Path(__file__).parents[1] / "fixtures" / "robots"
DOG = FIXTURES / "dog_description" / "urdf" / "dog.urdf"


def read(path, roots=()):
    """Import in this process, as the child does."""
    result = convert(str(path), [str(root) for root in roots])
    model = mujoco.MjModel.from_xml_string(result["text"])
    return model, " | ".join(result["repairs"]), result["text"]


def body(model, name):
    return model.body(name).id


def test_a_urdf_of_a_package_keeps_mass_joints_and_feet():
    model, repairs, _ = read(DOG)
    # Sum of the file's masses: 2 + 0.5 of the trunk and its sensor, 4 × (0.3 + 0.1).
    assert model.body_mass.sum() == pytest.approx(4.1, rel=1e-6)
    assert model.body_mass[body(model, "trunk")] == pytest.approx(2.5, rel=1e-6)
    # Two masses on a line: the mean, and Steiner's theorem.
    assert model.body_ipos[body(model, "trunk")] == pytest.approx([0.04, 0, 0.01], abs=1e-6)
    joints = [model.joint(index).name for index in range(1, model.njnt)]
    assert joints == [
        f"{leg}_{part}" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "knee")
    ]
    knee = model.joint("FL_knee")
    assert knee.range == pytest.approx([-2, -0.5])
    assert model.jnt_actfrcrange[knee.id] == pytest.approx([-7, 7])
    assert model.jnt_user[knee.id] == pytest.approx([12])
    assert "without limits, ±90° assumed: 'RR_hip'" in repairs
    assert "meshes not used: gone.stl (not found)" in repairs
    assert model.eq_type.tolist() == [mujoco.mjtEq.mjEQ_JOINT]
    assert model.eq_data[0, :2] == pytest.approx([0.1, -1.0])


def test_meshes_become_hulls_of_few_vertices():
    model, _, _ = read(DOG)
    shank = model.body("FL_shank")
    kinds = model.geom_type[shank.geomadr[0] :][: shank.geomnum[0]]
    assert kinds.tolist() == [mujoco.mjtGeom.mjGEOM_MESH]
    # A box of 20 × 20 × 200 mm, in COLLADA's millimetres and moved by its nodes.
    vertices = model.mesh_vert[: model.mesh_vertnum[0]]
    assert np.sort(np.ptp(vertices, axis=0)) == pytest.approx([0.02, 0.02, 0.2], abs=1e-5)
    assert model.mesh_vertnum.max() <= 64
