"""Animated glTF files: structure, movement interpolated as in the specification, and colours."""

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitsim.contracts import Skeleton, Solid, Terrain
from gaitsim.errors import PluginError, RunError
from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.scene import Clip
from gaitsim_exports.gltf.glb import glb, write_glb
from gltf import Gltf

SPIDER = load_experiment("spider")
BODIES = [
    ("spider", {}),
    *(
        pytest.param(name, options, marks=pytest.mark.slow)
        for name, options in [
            ("millipede", {}),
            ("fly", {}),
            ("walker-rough", {}),
            ("quadruped", {}),
            ("hexapod", {"organism.damage": ["R2 femur stuck 20", "L1 lost"]}),
        ]
    ),
]


def random_individual(preset, options=()):
    """Return a random individual of a preset."""
    experiment = load_experiment(preset, dict(options))
    genome = experiment.space().random(1, np.random.default_rng(3))[0]
    return Individual(experiment, 0.25, {}, 12, genome)


def individual_with(skeleton, **facts):
    """Return an individual with a given skeleton."""
    individual = Individual(SPIDER, 0.5, {}, 3, np.zeros(48), **facts)
    individual.__dict__["skeleton"] = skeleton
    return individual


def rods(segments, frame_rate=10.0, **more):
    """Return a skeleton of segments (frames, segments, 2, 3)."""
    segments = np.asarray(segments, float)
    names = tuple(f"L{i} rod" for i in range(segments.shape[1]))
    return Skeleton(segments, names, frame_rate, **more)


def interpolated(values, place):
    """Interpolate values linearly between frames."""
    before = min(int(place), len(values) - 2)
    return values[before] + (place - before) * (values[before + 1] - values[before])


@pytest.mark.parametrize(("preset", "options"), BODIES)
def test_feet_and_segment_ends_match_the_skeleton_at_any_time(preset, options):
    individual = random_individual(preset, options)
    skeleton, gltf = individual.skeleton, Gltf(glb(individual))
    anatomy, last = Clip(skeleton).anatomy, len(skeleton.segments) - 1
    chance = np.random.default_rng(5)
    places = [0, last, *chance.uniform(0, last, 20), *chance.integers(0, last, 5)]
    for place in places:
        time, segments = place / skeleton.frame_rate, interpolated(skeleton.segments, place)
        found = gltf.placed(gltf.numbers("centre")[0], [[0, 0, 0]], time)
        assert np.allclose(found, interpolated(skeleton.path, place), atol=1e-4)
        for foot, name in enumerate(skeleton.contact_names):
            (at,) = gltf.placed(gltf.numbers(name)[-1], [[0, 0, 0]], time)
            assert np.allclose(at, interpolated(skeleton.contacts, place)[foot], atol=1e-4)
        for limb in [] if skeleton.solids else anatomy.limbs:
            ends = skeleton.segments[:, limb]
            half = np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)) / 2
            node = gltf.numbers(skeleton.names[limb])[0]
            found = gltf.placed(node, [[0, 0, -half], [0, 0, half]], time)
            assert np.abs(found - segments[limb]).max() < 1e-3
        if place == int(place):  # fast rotations are not linear between frames
            for number, plate in enumerate([] if skeleton.solids else anatomy.plates):
                node = 1 + len(anatomy.limbs) + number
                found = gltf.placed(node, gltf.points(node), time)
                corners = segments.reshape(-1, 3)[list(plate)]
                away = np.linalg.norm(found[:, None] - corners, axis=2).min(axis=0)
                assert np.allclose(away, anatomy.plate_radii[number], atol=1e-5)
        for number in range(len(skeleton.solids)):
            at = gltf.placed(1 + number, [[0, 0, 0]], time)
            assert np.allclose(at, interpolated(skeleton.poses, place)[number, :3], atol=1e-5)


def test_file_has_title_and_score_and_is_reproducible(tmp_path):
    individual = random_individual("spider")
    write_glb(individual, tmp_path / "a.glb")
    data = (tmp_path / "a.glb").read_bytes()
    assert data == glb(random_individual("spider"))
    assert len(data) < 300_000
    tree = Gltf(data).tree
    assert tree["scenes"][0]["extras"] == {
        "title": "spider, generation 12",
        "score": 0.25,
        "generation": 12,
        "units": {"length": "m", "time": "s", "score": "m"},
    }
    assert tree["asset"]["generator"].startswith("gaitsim ")
    with pytest.raises(RunError):
        write_glb(individual, tmp_path / "nowhere" / "a.glb")


def test_rods_that_turn_lengthen_vanish_or_rest():
    ends = np.zeros((4, 5, 2, 3))
    ends[:, :, 1] = [0.3, 0, 0]
    ends[:, 1:] += np.arange(1, 5)[:, None, None] * [0, 1.0, 0]
    ends[1:, 1, 1] = [[0.3, 2, 0], [-0.3, 2, 0], [0, 2.5, 0]]  # half a turn, and longer
    ends[2, 2, 1] = ends[2, 2, 0]  # zero length
    ends[:, 3, 1, 2] = [0.1, 0.2, 0.3, 0.4]
    skeleton = rods(ends)
    gltf = Gltf(glb(individual_with(skeleton)))
    moving = {gltf.nodes[node]["name"] for node, _ in gltf.tracks}
    assert moving == {"L1 rod", "L2 rod", "L3 rod", "centre"}
    assert {path for node, path in gltf.tracks if gltf.nodes[node]["name"] == "L3 rod"} == {
        "translation",
        "rotation",
        "scale",
    }
    for frame in range(4):
        for rod in range(5):
            usual = np.median(np.linalg.norm(ends[:, rod, 1] - ends[:, rod, 0], axis=1))
            node = gltf.numbers(skeleton.names[rod])[0]
            found = gltf.placed(node, [[0, 0, -usual / 2], [0, 0, usual / 2]], frame / 10)
            assert np.allclose(found, ends[frame, rod], atol=1e-5)


def test_one_frame_has_no_animation_and_a_bent_plate_becomes_rods():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    square = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    still = Gltf(glb(individual_with(rods(square[None]))))
    assert "animations" not in still.tree
    assert [node["name"] for node in still.nodes[1:]] == ["body", "centre", "ground"]
    dented = np.where(square[..., :1] + square[..., 1:2] > 1.5, 0.3, square)
    bending = Gltf(glb(individual_with(rods([square, dented]))))
    assert [node["name"] for node in bending.nodes[1:5]] == [f"L{i} rod" for i in range(4)]


def test_solids_have_their_sizes_and_colours_and_equal_rotations_rest():
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]
    solids = (
        Solid("trunk", "box", (0.3, 0.2, 0.1)),
        Solid("L1 ball", "sphere", (0.2,)),
        Solid("L1 ball", "ellipsoid", (0.1, 0.2, 0.3)),
        Solid("R1 rod", "capsule", (0.1, 0.4)),
        Solid("R2 rod", "capsule", (0.1, 0.4)),
        Solid("R1 disc", "cylinder", (0.3, 0.05)),
        Solid("hull", "mesh", vertices=np.array(corners)),
    )
    poses = np.zeros((3, 7, 7))
    poses[..., 3] = [[1], [-1], [1]]  # the same rotation
    segments = np.zeros((3, 1, 2, 3))
    segments[..., 1, 0] = 1
    skeleton = rods(segments, solids=solids, poses=poses, damaged=("R2 rod",))
    gltf = Gltf(glb(individual_with(skeleton)))
    assert not gltf.tracks
    size = [np.ptp(gltf.points(1 + i), axis=0) for i in range(7)]
    expected = [
        [0.6, 0.4, 0.2],
        [0.4, 0.4, 0.4],
        [0.2, 0.4, 0.6],
        [0.2, 0.2, 1.0],
        [0.2, 0.2, 1.0],
        [0.6, 0.6, 0.1],
        [1, 1, 1],
    ]
    assert np.allclose(size, expected, atol=1e-6)
    materials = gltf.tree["materials"]
    hues = [
        materials[gltf.tree["meshes"][node["mesh"]]["primitives"][0]["material"]]["name"]
        for node in gltf.nodes[1:8]
    ]
    assert hues == ["body", "left", "left", "right", "damaged", "right", "body"]


def test_mesh_of_uneven_ground_includes_its_corners():
    segments = np.zeros((2, 1, 2, 3))
    segments[:, 0, 1, 2] = 1
    terrain = Terrain(np.array([[0.0, 0.1, 0.2], [0.0, 0.3, 0.1]]), 0.5, (-0.5, -0.25))
    uneven = Gltf(glb(individual_with(rods(segments, ground=terrain))))
    (node,) = uneven.numbers("ground")
    found = uneven.placed(node, uneven.points(node), 0)
    assert np.allclose(found[:, 2], terrain.height(found), atol=1e-6)
    assert {(0.0, 0.25, 0.3), (0.5, -0.25, 0.2)} <= {*map(tuple, np.round(found, 6).tolist())}
    profile = np.array([[-0.2, 0.0], [0.13, 0.4]])
    uneven = Gltf(glb(individual_with(rods(segments, ground=profile))))
    found = uneven.placed(node, uneven.points(node), 0)
    assert np.allclose(found[:, 2], np.interp(found[:, 0], *profile.T), atol=1e-6)
    assert np.isclose(found[:, 0], 0.13).any()


def test_any_names_and_scores_can_be_written():
    segments = np.zeros((2, 1, 2, 3))
    segments[1, 0, 1, 2] = 1
    skeleton = replace(rods(segments), names=('</script>"\ud800\n',))
    individual = replace(individual_with(skeleton), score=-np.inf)
    individual.__dict__["skeleton"] = skeleton
    gltf = Gltf(glb(individual))
    assert gltf.nodes[1]["name"] == '</script>"?\n'
    assert gltf.tree["scenes"][0]["extras"]["score"] is None
    with pytest.raises(PluginError, match="cannot be drawn"):
        glb(individual_with(rods(segments + np.nan)))


@pytest.fixture
def validator():
    """The folder of the Khronos glTF validator, an npm package, from $GLTF_VALIDATOR."""
    folder = Path(os.environ.get("GLTF_VALIDATOR", ""), "node_modules", "gltf-validator")
    if shutil.which("node") is None or not folder.is_dir():
        pytest.skip("needs Node and, in $GLTF_VALIDATOR, npm's gltf-validator")
    return folder.resolve()


@pytest.mark.slow
def test_khronos_validator_reports_no_issues(validator, tmp_path):
    script = (
        "const [validator, ...files] = process.argv.slice(1);"
        "for (const file of files)"
        "  require(validator).validateBytes(new Uint8Array(require('fs').readFileSync(file)))"
        "    .then(({issues}) => console.log(issues.numErrors + issues.numWarnings));"
    )
    files = []
    for parameters in BODIES:
        preset, options = getattr(parameters, "values", parameters)
        files.append(tmp_path / f"{preset}.glb")
        write_glb(random_individual(preset, options), files[-1])
    found = subprocess.run(
        ["node", "-e", script, validator, *files],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert found.stdout.split() == ["0"] * len(files), found.stderr
