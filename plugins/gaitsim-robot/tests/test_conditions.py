"""Effects of worlds on robots, against closed forms and MuJoCo's own compiler."""

import math
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from stick import quadruped_spec, simulation_of, standing_quadruped

from gaitsim.contracts import Terrain
from gaitsim.errors import GaitsimError
from gaitsim.legged import downward
from gaitsim_robot import loading
from gaitsim_robot.conditions import apply_world, robot_conditions
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import delayed_commands, walk

GRAVITY = 9.81
CONDITIONS = robot_conditions(0.8, 0.02)
FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS


def standing(world, seconds=2.0, **options):
    """Return a quadruped that holds the standing pose in a world, and its motion."""
    simulation = apply_world(standing_quadruped("ideal", **options)[0], world)
    commands = simulation.anatomy.stance[simulation.qpos]
    frames = round(seconds * 50) + 1
    return simulation, walk(simulation, np.tile(commands, (1, frames, 1)))


def genomes(robot, count):
    space = robot.genome_space()
    return np.random.default_rng(5).uniform(space.lower, space.upper, (count, len(space.lower)))


@pytest.mark.parametrize("slope", ["slope", "side_slope"])
def test_a_robot_slides_on_slopes_steeper_than_its_friction_and_stands_on_others(slope):
    friction, steep, flat = 0.2, 16.0, 7.0  # atan(0.2) = 11.3°
    simulation = apply_world(standing_quadruped("ideal")[0], {slope: steep, "friction": friction})
    data = mujoco.MjData(simulation.model)
    mujoco.mj_setState(simulation.model, data, simulation.start, FULL)
    data.ctrl[:] = simulation.rest
    axis = ("slope", "side_slope").index(slope)
    speeds = []
    for _ in range(2):
        mujoco.mj_step(simulation.model, data, 50)
        mujoco.mj_subtreeVel(simulation.model, data)
        speeds.append(data.subtree_linvel[1, axis])
    # The acceleration of a sliding block, downhill.
    angle = math.radians(steep)
    expected = -GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * 0.2
    assert np.diff(speeds) == pytest.approx(expected, rel=0.08)
    _, motion = standing({slope: flat, "friction": friction})
    assert motion["lasted"] == 2.0
    moved = np.linalg.norm(motion["torso"][0, -1] - motion["torso"][0, 0])
    assert moved < 0.02  # contacts with friction creep in MuJoCo


def test_a_slope_rotates_gravity_opposite_to_the_ground():
    from scipy.spatial.transform import Rotation

    ground = Rotation.from_euler("YX", [-12, 7], degrees=True)
    down = ground.inv().apply([0, 0, -1])
    assert downward({"slope": 12, "side_slope": 7}) == pytest.approx(down, abs=1e-15)


def test_the_load_on_the_feet_is_the_weight_of_all_masses():
    light, motion = standing({"mass": 0.8})
    _, heavy = standing({"mass": 1.2})
    own = standing_quadruped("ideal")[0].anatomy.mass
    for share, found in ((0.8, motion), (1.2, heavy)):
        load = found["load"][0, -1, :, 2].sum()
        assert load == pytest.approx(share * own * GRAVITY, rel=0.01)
        assert found["weight"] == pytest.approx(share * own * GRAVITY)
    assert light.anatomy.mass == pytest.approx(0.8 * own)


def test_a_robot_in_a_world_equals_one_compiled_from_a_modified_specification():
    world = {"mass": 1.3, "friction": 0.45, "servo_torque": 0.8, "servo_speed": 0.7}
    found = apply_world(standing_quadruped("sts3215")[0], world).model
    spec = quadruped_spec()
    for body in spec.bodies[1:]:
        body.mass *= 1.3
        body.inertia = 1.3 * body.inertia
        body.fullinertia = 1.3 * body.fullinertia
    options = {"torque_limit": 0.8 * 1.91229675, "speed_limit": 0.7 * math.pi / 3 / 0.192}
    model = simulation_of(spec, "sts3215", friction=0.45, **options)[0].model
    gear = model.dof_armature[6:] / found.dof_armature[6:]
    assert gear == pytest.approx(1)
    for name in (
        "body_mass",
        "body_inertia",
        "body_subtreemass",
        "body_invweight0",
        "dof_invweight0",
        "geom_friction",
        "actuator_gainprm",
        "actuator_biasprm",
        "actuator_forcerange",
        "actuator_acc0",
    ):
        np.testing.assert_allclose(getattr(found, name), getattr(model, name), rtol=1e-9)


def test_the_condition_latency_equals_the_option_and_delays_commands():
    robot = Robot(duration=1, servo="sts3215")
    some = genomes(robot, 3)
    by_world = robot.model_copy(update={"world": {"latency": 0.05}}).move(some)
    option = Robot(duration=1, servo="sts3215", latency=0.05).move(some)
    for name in option:
        np.testing.assert_array_equal(by_world[name], option[name])
    simulation, _ = standing_quadruped("sts3215", dt=0.004)
    late = apply_world(simulation, {"latency": 0.044})
    commands = np.random.default_rng(1).random((2, 21, len(simulation.ctrl)))
    before, after = (delayed_commands(one, commands, 0, 20) for one in (simulation, late))
    np.testing.assert_array_equal(after[:, 6:], before[:, :-6])  # 20 and 44 ms


def test_offsets_shift_the_joints_of_a_floating_robot_within_their_limits():
    world = {"joint_offset": 2.0, "seed": 3}
    simulation = apply_world(standing_quadruped("ideal", friction=0.8)[0], world)
    model, data = simulation.model, mujoco.MjData(simulation.model)
    mujoco.mj_setState(model, data, simulation.start, FULL)
    model.opt.gravity[:] = 0
    data.qpos[2] += 1
    commands = np.tile(simulation.anatomy.stance[simulation.qpos], (1, 51, 1))
    data.ctrl[:] = delayed_commands(simulation, commands, 0, 50)[0, -1]
    mujoco.mj_step(model, data, 500)
    off = data.qpos[simulation.qpos] - commands[0, 0]
    assert off == pytest.approx(simulation.offset, abs=1e-3)
    assert 0.2 < np.degrees(off).std() / 2 < 2
    lower, upper = model.actuator_ctrlrange[simulation.ctrl].T
    beyond = delayed_commands(simulation, np.tile(upper, (1, 3, 1)), 0, 2)[..., simulation.ctrl]
    assert (beyond <= upper).all()
    assert (beyond < upper).any()
    assert (beyond >= lower).all()
    other = apply_world(standing_quadruped("ideal")[0], {**world, "seed": 4})
    assert not np.isclose(other.offset, simulation.offset).any()


@pytest.mark.parametrize("name", CONDITIONS)
def test_a_nominal_value_does_not_change_any_bit(name):
    robot = Robot(duration=0.5, servo="sts3215", friction=0.7)
    some = genomes(robot, 2)
    world = {name: robot.conditions()[name].nominal}
    for damage in ((), ("L1 lost",)):
        body = robot.model_copy(update={"damage": damage})
        nominal = body.move(some)
        motion = body.model_copy(update={"world": world}).move(some)
        for channel in nominal:
            np.testing.assert_array_equal(motion[channel], nominal[channel])


def test_a_robot_in_a_world_has_the_same_bits_in_every_thread_and_chunk():
    world = {name: one.low + 0.3 * (one.high - one.low) for name, one in CONDITIONS.items()}
    robot = Robot(model="hexapod", duration=1.0, servo="sts3215", world={**world, "seed": 8})
    some = genomes(robot, 6)
    before = loading._simulation_in_world.cache_info().misses
    with ThreadPoolExecutor(3) as threads:
        parts = list(threads.map(robot.move, np.split(some, 3)))
    # Only one of the threads compiles the robot.
    assert loading._simulation_in_world.cache_info().misses == before + 1
    together = robot.move(some)
    played = robot.play(together["joint_angles"])
    for name in together:
        np.testing.assert_array_equal(np.concatenate([one[name] for one in parts]), together[name])
    whole = together["lasted"] >= 0.98
    assert whole.any()
    np.testing.assert_array_equal(played["torso"][whole], together["torso"][whole])


@pytest.mark.parametrize(
    ("world", "message"),
    [({"wind": 1.0}, "wind"), ({"slope": 50.0}, "-45 to 45 °"), ({"mass": 0.0}, "0.1 to 10")],
)
def test_invalid_worlds_are_refused(world, message):
    with pytest.raises(GaitsimError, match=message) as caught:
        Robot(world=world)
    assert caught.value.key == "world"


def test_a_push_changes_the_velocity_of_the_whole_robot():
    world = {"push": 0.4, "seed": 6}
    nominal, pushed = (
        walk(robot, np.tile(robot.anatomy.stance[robot.qpos], (1, 101, 1)))
        for robot in (apply_world(standing_quadruped("ideal")[0], one) for one in ({}, world))
    )
    simulation = apply_world(standing_quadruped("ideal")[0], world)
    mass = Robot(world={"mass": 1.2}).simulation.anatomy.mass
    described = Robot(world={"mass": 1.2, "push": 0.4}).describe()["World"]["push"]
    assert described == f"0.4 m/s = {0.4 * mass:.3g} N s"
    frame, velocity = simulation.push(101)
    assert np.hypot(*velocity[:2]) == pytest.approx(0.4)
    difference = pushed["torso_velocity"][0] - nominal["torso_velocity"][0]
    assert np.abs(difference[:frame]).max() < 1e-3
    assert difference[frame] == pytest.approx(velocity, abs=2e-3)
    moved = pushed["torso"][0, -1, :2] - pushed["torso"][0, frame, :2]
    assert moved @ velocity[:2] > 0.001


def test_a_robot_with_initial_errors_starts_on_the_ground_and_returns_to_its_pose():
    world = {"initial_pose": 4.0, "seed": 2}
    robot = Robot(model="hexapod", servo="sts3215", damage=("R1 femur stuck 20",), world=world)
    nominal = robot.model_copy(update={"world": {}}).simulation
    simulation = robot.simulation
    start, rest = (one.start[1 + one.qpos] for one in (simulation, nominal))
    stuck = simulation.anatomy.joints.index("R1 femur")
    off = np.degrees(start - rest)
    assert off[stuck] == 0
    assert 2 < np.delete(off, stuck).std() < 6
    motion = robot.play(np.tile(simulation.anatomy.stance[simulation.qpos], (1, 101, 1)))
    still = nominal.start[1 + nominal.qpos]
    assert motion["joint_positions"][0, -1] == pytest.approx(still, abs=0.03)
    assert motion["foot_positions"][0, 0, :, 2].min() > -1e-3
    assert motion["lasted"] == 2.0


def test_commands_at_a_low_rate_are_held():
    simulation = apply_world(standing_quadruped("sts3215", latency=0)[0], {"command_rate": 10})
    commands = np.cumsum(np.full((1, 21, 12), 0.01), axis=1)
    commanded = delayed_commands(simulation, commands, 0, 20)[0, :, simulation.ctrl[0]]
    np.testing.assert_allclose(commanded[:-1], np.repeat(0.01 + 0.05 * np.arange(4), 25))
    ends = [delayed_commands(simulation, commands, *span)[0] for span in ((0, 7), (7, 20))]
    np.testing.assert_array_equal(ends[1], delayed_commands(simulation, commands, 0, 20)[0, 35:])


def test_uneven_ground_has_the_heights_of_mujoco_and_carries_the_robot():
    world = {"unevenness": 0.02, "seed": 1}
    robot = Robot(model="hexapod", servo="sts3215", symmetry="alternating", duration=4, world=world)
    simulation = robot.simulation
    data = mujoco.MjData(simulation.model)
    mujoco.mj_forward(simulation.model, data)
    ground = simulation.model.geom("world: ground").id
    places = np.random.default_rng(0).uniform(-1.5, 1.5, (200, 2))
    seen = [
        1 - mujoco.mj_rayHfield(simulation.model, data, ground, [x, y, 1.0], [0.0, 0.0, -1.0])
        for x, y in places
    ]
    assert simulation.ground is not None
    np.testing.assert_allclose(simulation.ground.height(places), seen, atol=1e-6)
    assert 0.018 < simulation.ground.heights.max() <= 0.02
    longer = robot.model_copy(update={"duration": 6.0}).simulation.ground
    assert longer is not None
    np.testing.assert_allclose(longer.height(places), simulation.ground.height(places), atol=1e-12)

    motion = robot.move(genomes(robot, 4))
    feet = motion["foot_positions"] + [*simulation.start[1:3], 0]
    clear = feet[..., 2] - simulation.ground.height(feet)
    touching = motion["stance"] & np.roll(motion["stance"], -1, axis=1)
    assert np.abs(clear[touching]).max() < 0.02
    assert clear.min() > -0.01
    height = motion["torso"][..., 2] - motion["height"]
    assert 0 <= height.min() < height.max() <= 0.02
    load = motion["load"][:, 50:, :, 2].sum(axis=2).mean(axis=1)
    standing = motion["lasted"] == 4.0
    assert standing.any()
    assert load[standing] == pytest.approx(motion["weight"][standing], rel=0.03)


def test_skeletons_have_their_feet_on_slopes_and_bumps():
    world = {"slope": 8.0, "side_slope": -5.0, "unevenness": 0.01, "seed": 1}
    robot = Robot(model="hexapod", servo="sts3215", symmetry="alternating", duration=2)
    some = genomes(robot, 1)
    conditions: dict[str, float]
    for conditions in ({}, {"slope": 8.0}, world):
        body = robot.model_copy(update={"world": conditions})
        motion = body.move(some)
        skeleton = body.skeleton(motion, 0)
        ground = skeleton.ground
        height = ground.height(skeleton.contacts) if isinstance(ground, Terrain) else 0.0
        above = skeleton.contacts[..., 2] - height
        assert np.abs(above[skeleton.touching]).max() < 0.02
        moved = skeleton.path[-1] - skeleton.path[0]
        along = motion["torso"][0, -1] - motion["torso"][0, 0]
        down = downward(conditions)
        assert moved[2] == pytest.approx(-along @ down)
        assert np.linalg.norm(moved) == pytest.approx(np.linalg.norm(along))
        solids = skeleton.poses[..., :3]
        assert np.linalg.norm(solids - skeleton.path[:, None], axis=-1).max() < 0.5
    assert skeleton.path[-1, 2] > skeleton.path[0, 2]
