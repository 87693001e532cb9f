"""Designs written as MJCF and URDF, and their drawing."""

import numpy as np
import pytest
from small_robots import QUADRUPED

import gaitsim as gs
from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.plots.style import LIGHT
from gaitsim_plots.drawing import drawing_figure
from gaitsim_robot.urdf import mesh_files

EVOLVING = {"organism.evolve": ["thigh", "shank"], "organism.duration": 1.0}
BAR = np.array([[x, y, z] for x in (-0.01, 0.01) for y in (-0.01, 0.01) for z in (-0.18, 0)])


def individual(preset, factors, options=EVOLVING):
    """Return an individual with a gait made by hand, and given factors."""
    experiment = load_experiment(preset, options)
    genome = next(iter(experiment.organism.starts().values()))
    genome[len(genome) - len(factors) :] = factors
    return Individual(experiment, 0.0, {}, 1, genome)


def test_a_design_leaves_as_mjcf_that_moves_the_same(tmp_path):
    one = individual("quadruped", [1.1, 0.9])
    done = gs.export(one, tmp_path / "robot.xml", "mjcf")
    assert "organism.latency=0.02" in done.notices[0]
    options = {"organism.latency": 0.02, "organism.duration": 1.0}
    again = load_experiment(str(tmp_path / "robot.xml"), options).organism
    motion = one.motion
    assert np.abs(again.play(motion["joint_angles"])["torso"] - motion["torso"]).max() < 1e-6


def test_a_design_leaves_as_urdf_that_stands_the_same(tmp_path):
    one = individual("quadruped", [1.1, 0.9])
    body = one.experiment.organism.embody(one.genome)[0]
    gs.export(one, tmp_path / "robot.urdf", "urdf")
    joints, pose = body.joint_names(), np.degrees(body.standing_pose()).tolist()
    stance = dict(zip(joints, pose, strict=True))
    options = {"organism.servo": "sts3215", "organism.stance": stance}
    again = load_experiment(str(tmp_path / "robot.urdf"), options).organism
    assert again.anatomy.mass == pytest.approx(body.anatomy.mass, rel=1e-5)
    motion = one.motion["torso"]
    played = again.play(one.motion["joint_angles"])["torso"]
    # Digits are rounded, and contacts amplify differences.
    assert np.abs(played[:, :25] - motion[:, :25]).max() < 1e-5


def test_meshes_leave_in_metres(tmp_path):
    corners = " ".join(map(str, BAR.ravel()))
    text = QUADRUPED.replace(
        '<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.015" mass="0.2"/>',
        '<geom type="mesh" mesh="bar" mass="0.2"/>',
    ).replace("<worldbody>", f'<asset><mesh name="bar" vertex="{corners}"/></asset><worldbody>')
    source = tmp_path / "source.xml"
    source.write_text(text)
    one = individual(str(source), [1.5, 1.0], EVOLVING | {"organism.ranges.thigh": [0.5, 2.0]})
    gs.export(one, tmp_path / "robot.urdf", "urdf")
    files = sorted((tmp_path / "robot-meshes").iterdir())
    assert len(files) == 4
    body = one.experiment.organism.embody(one.genome)[0]
    [name, *_] = mesh_files(body.simulation.model)
    data = (tmp_path / "robot-meshes" / name).read_bytes()
    count = int.from_bytes(data[80:84], "little")
    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    triangles = np.frombuffer(data[84:], layout)
    assert len(triangles) == count
    corners = triangles["corners"].astype(float)
    # The signed volume of a closed surface whose triangles face outward is the box's.
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(0.02 * 0.02 * 0.27, rel=1e-4)
    read = load_experiment(str(tmp_path / "robot.urdf")).organism
    assert read.anatomy.mass == pytest.approx(body.anatomy.mass, rel=1e-5)


def test_a_drawing_has_the_lengths_of_both_bodies():
    figure = drawing_figure(individual("quadruped", [1.1, 0.9]), LIGHT)
    cells = {cell.get_text().get_text() for cell in figure.axes[2].tables[0].get_celld().values()}
    assert {"thigh", "110.0", "121.0", "1.100", "shank", "99.0", "0.900"} <= cells
    labels = {text.get_text() for text in figure.axes[0].texts}
    assert "121.0" in labels
