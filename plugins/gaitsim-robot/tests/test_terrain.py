"""Steps and rubble against closed forms and MuJoCo."""

import itertools

import mujoco
import numpy as np
import pytest
from stick import standing_quadruped

from gaitsim.contracts import Terrain
from gaitsim.errors import GaitsimError
from gaitsim_robot.organism import Robot
from gaitsim_robot.terrain import BLOCK, EDGE, MOST, add_ground, lattice_for, raise_ground

ANATOMY = standing_quadruped("ideal")[0].anatomy
LENGTH = ANATOMY.length
LEVEL = 0.6 * LENGTH


def ground_of(world, seconds=2.0, radius=0.0, places=()):
    """Return terrain, and a compiled world with its height field and balls above it."""
    spec = mujoco.MjSpec()
    add_ground(spec, ANATOMY, lattice_for(world, seconds), 1.0)
    for x, y in places:
        ball = spec.worldbody.add_body(pos=[x, y, 0.0])
        ball.add_freejoint()
        ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0])
    model = spec.compile()
    return raise_ground(model, world, LEVEL), model


def flat_places(terrain, count):
    """Return the middles of squares that are level, as are all their neighbours, (count, 2) m."""
    windows = np.lib.stride_tricks.sliding_window_view(terrain.heights, (4, 4))
    row, column = np.nonzero(np.ptp(windows, axis=(2, 3)) == 0)
    chosen = np.random.default_rng(0).choice(len(row), count, replace=False)
    middle = np.stack([column, row], axis=1)[chosen] + 1.5
    return terrain.corner + terrain.spacing * middle


@pytest.mark.parametrize("world", [{"steps": 0.03}, {"rubble": 0.05}, {"steps": 0.2}])
def test_a_ball_rests_at_the_height_of_the_ground(world):
    world, radius = {**world, "seed": 4}, 0.2 * EDGE * LENGTH
    terrain, _ = ground_of(world)
    places = flat_places(terrain, 12)
    heights = terrain.height(places)
    assert len({*heights.round(6)}) > 2
    _, model = ground_of(world, radius=radius, places=places)
    data = mujoco.MjData(model)
    data.qpos.reshape(-1, 7)[:, 2] = heights + 1.2 * radius
    mujoco.mj_step(model, data, 500)
    resting = data.qpos.reshape(-1, 7)[:, :3]
    assert resting[:, :2] == pytest.approx(places, abs=1e-3)
    assert resting[:, 2] == pytest.approx(heights + radius, abs=3e-4)


@pytest.mark.parametrize(
    "world",
    [{"steps": 0.02}, {"rubble": 0.03}, {"unevenness": 0.01, "steps": 0.02, "rubble": 0.03}],
)
def test_the_ground_has_the_heights_of_mujoco_and_is_level_at_the_start(world):
    terrain, model = ground_of({**world, "seed": 7})
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    places = np.random.default_rng(0).uniform(-6 * LENGTH, 6 * LENGTH, (200, 2))
    seen = [
        1 - mujoco.mj_rayHfield(model, data, 0, [x, y, 1.0], [0.0, 0.0, -1.0]) for x, y in places
    ]
    np.testing.assert_allclose(terrain.height(places), seen, atol=1e-6)
    turns = np.linspace(0, 2 * np.pi, 100)
    around = LEVEL * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    assert not terrain.height(around).any()


def test_terraces_differ_by_one_step_and_stay_within_two_of_the_start():
    step, levels = 0.02, set()
    for seed in range(8):
        terrain, _ = ground_of({"steps": step, "seed": seed}, 4.0)
        assert (np.ptp(terrain.heights, axis=0) == 0).all()
        profile = np.rint(terrain.heights[0] / step)
        np.testing.assert_allclose(terrain.heights[0], step * profile, atol=1e-6)
        assert {*np.abs(np.diff(profile))} == {0.0, 1.0}
        long = [len([*same]) for _, same in itertools.groupby(profile)][1:-1]
        start = len(long) // 2
        assert {*long[:start], *long[start + 1 :]} == {round(1 / EDGE)}
        levels |= {*profile}
    assert levels == {-2, -1, 0, 1, 2}


def test_blocks_have_flat_tops_and_heights_up_to_the_rubble():
    terrain, _ = ground_of({"rubble": 0.04, "seed": 2}, 4.0)
    middle, half = len(terrain.heights) // 2, BLOCK // 2
    first = middle - half - BLOCK * ((middle - half) // BLOCK)
    count = (len(terrain.heights) - first) // BLOCK
    inner = slice(first, first + count * BLOCK)
    blocks = terrain.heights[inner, inner].reshape(count, BLOCK, count, BLOCK)
    assert (np.ptp(blocks, axis=(1, 3)) == 0).all()
    tops = blocks[:, 0, :, 0]
    assert 0.039 < tops.max() <= 0.04 + 1e-7
    assert tops[tops > 0].mean() == pytest.approx(0.02, rel=0.05)  # a uniform distribution


@pytest.mark.parametrize("name", ["steps", "rubble", "unevenness"])
def test_the_seed_alone_determines_the_ground(name):
    short, long, other = (
        ground_of({name: 0.02, "seed": seed}, seconds)[0]
        for seed, seconds in ((3, 1.0), (3, 7.0), (4, 1.0))
    )
    places = np.random.default_rng(1).uniform(-4 * LENGTH, 4 * LENGTH, (300, 2))
    np.testing.assert_allclose(short.height(places), long.height(places), atol=1e-12)
    assert not np.allclose(short.height(places), other.height(places), atol=1e-3)


def test_heights_of_bumps_steps_and_rubble_add_up():
    parts = {"unevenness": 0.01, "steps": 0.02, "rubble": 0.03}
    places = np.random.default_rng(1).uniform(-5 * LENGTH, 5 * LENGTH, (300, 2))
    together = ground_of({**parts, "seed": 5})[0].height(places)
    alone = [ground_of({name: one, "seed": 5})[0].height(places) for name, one in parts.items()]
    np.testing.assert_allclose(together, sum(alone), atol=1e-6)


def test_long_walks_have_ground_of_limited_size():
    lattice = lattice_for({"rubble": 0.01}, 60.0)
    assert lattice is not None
    assert lattice.corners == MOST
    assert lattice_for({"steps": 0.0, "rubble": 0.0, "unevenness": 0.0}, 60.0) is None


def test_the_memory_of_bumps_is_bounded_for_long_walks():
    bumps = {"unevenness": 0.01}
    assert lattice_for(bumps, 10.0) != lattice_for(bumps, 60.0) == lattice_for(bumps, 600.0)


@pytest.mark.parametrize("name", ["steps", "rubble"])
def test_a_robot_stands_and_walks_on_steps_and_rubble(name):
    robot = Robot(model="hexapod", servo="sts3215", duration=4, world={name: 0.01, "seed": 1})
    assert robot.simulation.stands
    start = np.stack(list(robot.starts().values()))[:1]
    motion = robot.move(start)
    assert motion["lasted"] == 4.0
    ground = robot.simulation.ground
    assert ground is not None
    origin = np.array([*robot.simulation.start[1:3], 0])
    feet = motion["foot_positions"] + origin
    assert (feet[..., 2] - ground.height(feet)).min() > -0.01
    drawn = robot.skeleton(motion, 0).ground
    assert isinstance(drawn, Terrain)
    assert drawn.heights.size < ground.heights.size / 2
    torso = motion["torso"]
    np.testing.assert_allclose(drawn.height(torso), ground.height(torso + origin), atol=1e-9)


def test_the_part_of_a_terrain_near_points_has_the_same_heights():
    terrain = Terrain(np.random.default_rng(0).random((9, 12)), 0.5, (-2.0, 1.0))
    points = np.array([[[-1.2, 2.1], [0.4, 3.3]], [[0.0, 2.0], [-0.3, 2.2]]])
    part = terrain.near(points, 0.3)
    assert part.heights.shape == (6, 6)  # x from -1.5 to 1, y from 1.5 to 4
    around = points + np.random.default_rng(1).uniform(-0.3, 0.3, (50, 2, 2, 2))
    np.testing.assert_allclose(part.height(around), terrain.height(around), atol=1e-12)
    outside = terrain.near(np.array([[50.0, -50.0, 0.0]]), 1.0)
    assert outside.heights.shape == (2, 2)
    assert outside.height(np.array([50.0, -50.0])) == terrain.heights[0, -1]


@pytest.mark.parametrize("name", ["steps", "rubble"])
def test_the_other_engine_refuses_uneven_ground(name):
    pytest.importorskip("pybullet")
    robot = Robot(engine="bullet", duration=0.5, world={name: 0.01})
    with pytest.raises(GaitsimError, match="uneven ground") as caught:
        robot.move(np.stack(list(robot.starts().values()))[:1])
    assert caught.value.key == "engine"
