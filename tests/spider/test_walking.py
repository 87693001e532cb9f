"""Contact, travel and stability against closed forms and brute force."""

import itertools

import numpy as np
import pytest
import reference
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from gaitsim.contracts import Motion
from gaitsim.legged import downward
from gaitsim_spider import body
from gaitsim_spider.damage import damaged_anatomy
from gaitsim_spider.intervals import BLOCK, whole_blocks
from gaitsim_spider.kinematics import leg_points, place_feet
from gaitsim_spider.organism import Spider
from gaitsim_spider.walking import STANCE_TOLERANCE, walk

INTACT = damaged_anatomy(()).legs
FEET = np.zeros((8, 3))
FEET[:, 0] = [0.16, 0.056, -0.056, -0.16] * 2
FEET[:, 1] = [0.155, 0.186, 0.186, 0.155, -0.155, -0.186, -0.186, -0.155]
FEET[:, 2] = -0.078


def walked(
    feet: np.ndarray,
    centre: np.ndarray | None = None,
    lean: tuple[float, float] | None = None,
) -> dict[str, np.ndarray]:
    """Return the channels of one body whose feet move as given, (frames, 8, 3)."""
    frames = len(feet)
    centre = np.zeros((frames, 3)) if centre is None else centre
    out = {
        "pose": np.empty((1, 3, frames), np.float32),
        "stance": np.empty((1, 8, frames), np.bool_),
        "slip": np.empty((1, frames), np.float32),
        "margin": np.empty((1, frames), np.float32),
        "slope": np.empty((1, frames), np.float32),
    }
    inputs = (
        np.zeros((1, 3, 8, whole_blocks(frames)), np.float32),
        np.zeros((1, 3, whole_blocks(frames)), np.float32),
    )
    inputs[0][..., :frames], inputs[1][..., :frames] = feet.transpose(2, 1, 0), centre.T
    angles = np.empty((1, 24, frames), np.float32)
    walk(angles, None, lean, *inputs, np.zeros(1, BLOCK), *out.values())
    return {name: values[0].T for name, values in out.items()}


@pytest.mark.slow
def test_feet_that_move_straight_back_carry_the_body_straight_forward() -> None:
    feet = np.repeat(FEET[None], 31, axis=0)
    feet[:, :, 0] -= 0.001 * np.arange(31)[:, None]
    result = walked(feet)
    np.testing.assert_allclose(result["pose"][-1], [0.03, 0, 0], atol=1e-6)
    assert result["stance"].all()
    assert result["slip"].max() < 1e-7


@pytest.mark.slow  # compiles a kernel that nothing else calls
def test_feet_that_turn_right_turn_the_body_left_about_its_centre() -> None:
    turns = np.radians(-0.5 * np.arange(41))
    feet = Rotation.from_euler("z", turns[:, None]).as_matrix()[:, None] @ FEET[None, :, :, None]
    result = walked(feet[..., 0])
    np.testing.assert_allclose(result["pose"][-1], [0, 0, np.radians(20)], atol=2e-4)


@pytest.mark.slow  # compiles it, too
def test_travel_follows_the_heading() -> None:
    """A constant twist leads along a circle of radius v/ω."""
    turn, step = np.radians(1.0), 0.002
    feet = [FEET]
    back = Rotation.from_euler("z", -turn).as_matrix()
    for _ in range(90):
        feet.append((feet[-1] - [step, 0, 0]) @ back.T)
        # The feet are not limited to the reach of their legs.
    pose = walked(np.array(feet))["pose"]
    radius = step / turn
    np.testing.assert_allclose(pose[-1], [radius, radius, np.pi / 2], rtol=0.03, atol=0.002)


def test_lifted_feet_do_not_carry() -> None:
    feet = np.repeat(FEET[None], 2, axis=0)
    lifted = [0, 2, 5, 7]
    feet[:, lifted, 2] += 0.02
    feet[1, lifted, 0] += 0.01  # lifted feet swing forward
    feet[1, [1, 3, 4, 6], 0] -= 0.004
    result = walked(feet)
    np.testing.assert_array_equal(np.flatnonzero(~result["stance"][0]), lifted)
    np.testing.assert_allclose(result["pose"][-1], [0.004, 0, 0], atol=1e-6)


def test_slip_is_the_residual_of_the_rigid_motion() -> None:
    feet = np.repeat(FEET[None], 2, axis=0)
    feet[1, :4, 1] += 0.001  # both sides move outwards, which no motion of the body can follow
    feet[1, 4:, 1] -= 0.001
    result = walked(feet)
    np.testing.assert_allclose(result["slip"][0], 0.001, rtol=1e-3)
    np.testing.assert_allclose(result["pose"][-1], 0, atol=1e-7)


def test_a_flip_flop_does_not_travel() -> None:
    """Two groups of feet alternate in every frame between stance and swing."""
    feet = np.repeat(FEET[None], 300, axis=0)
    even = [0, 2, 5, 7]
    odd = [1, 3, 4, 6]
    for group, phase in ((even, 0), (odd, 1)):
        down = (np.arange(300) + phase) % 2 == 0
        feet[:, group, 2] += np.where(down, 0, 0.004)[:, None]
        feet[:, group, 0] += np.where(down, 0.005, -0.005)[:, None]
    assert abs(walked(feet)["pose"][-1, 0]) < 1e-5


def test_standing_has_no_slope_and_the_margin_of_its_hull() -> None:
    result = walked(np.repeat(FEET[None], 2, axis=0))
    assert result["slope"].max() < 1e-6
    hull = ConvexHull(FEET[:, :2])
    np.testing.assert_allclose(result["margin"][0], -hull.equations[:, 2].max(), rtol=1e-4)


def test_a_centre_outside_its_support_has_a_negative_margin() -> None:
    feet = np.repeat(FEET[None], 2, axis=0)
    feet[:, [0, 1], 2] += 0.02  # front left feet are up
    centre = np.repeat([[0.12, 0.12, 0.0]], 2, axis=0)
    margin = walked(feet, centre)["margin"][0]
    assert margin < 0 or walked(feet, centre)["stance"][0, [0, 1]].any()


def random_poses(count: int) -> tuple[np.ndarray, np.ndarray]:
    angles = np.random.default_rng(0).uniform(-0.35, 0.35, (count, 24, 2)).astype(np.float32)
    angles[..., 1] = angles[..., 0]  # standing: equal poses at both ends of the interval
    feet, centre = np.empty((count, 3, 8, 2), np.float32), np.empty((count, 3, 2), np.float32)
    place_feet(angles, INTACT, feet, centre)
    return feet, centre


def test_the_resting_plane_is_the_lower_hull_under_the_centre() -> None:
    """The reference is SciPy's convex hull of the feet in random poses."""
    feet, centre = random_poses(100)
    for individual in range(100):
        points = feet[individual, :, :, 0].T.astype(float)
        balance = centre[individual, :, 0].astype(float)
        result = walked(np.repeat(points[None], 2, axis=0), np.repeat(balance[None], 2, axis=0))
        hull = ConvexHull(points)
        below = hull.equations[hull.equations[:, 2] < -1e-9]  # facets that face down
        heights = -(below[:, :2] @ balance[:2] + below[:, 3]) / below[:, 2]
        facet = below[np.argmax(heights)]  # the lower hull is the highest of its planes
        np.testing.assert_allclose(result["slope"][0], np.arccos(-facet[2]), atol=2e-3)
        distance = -(points @ facet[:3] + facet[3])
        clear = np.abs(distance - STANCE_TOLERANCE) > 1e-5
        expected = distance < STANCE_TOLERANCE
        np.testing.assert_array_equal(result["stance"][0][clear], expected[clear])


@pytest.mark.sampled
@pytest.mark.parametrize(
    "spider",
    [
        Spider(),
        Spider(symmetry="alternating", frequency=1.3),
        Spider(symmetry="alternating", world={"slope": 12.0, "side_slope": -7.0}),
    ],
    ids=str,
)
def test_walking_agrees_with_an_independent_reference(spider: Spider) -> None:
    motion = spider.move(spider.genome_space().random(2, np.random.default_rng(4)))
    down = downward(spider.world)
    for individual in range(2):
        pose, stance, slip, margin, slope = reference.walk(
            motion["feet"][individual], motion["centre_of_mass"][individual], -down[:2] / down[2]
        )
        np.testing.assert_array_equal(motion["stance"][individual, :-1], stance)
        np.testing.assert_allclose(motion["pose"][individual], pose, atol=1e-5)
        np.testing.assert_allclose(motion["slip"][individual, :-1], slip, atol=1e-7)
        np.testing.assert_allclose(motion["margin"][individual, :-1], margin, atol=1e-6)
        np.testing.assert_allclose(motion["slope"][individual, :-1], slope, atol=1e-5)


def standing(lifted: list[str], **world: float) -> tuple[Motion, np.ndarray]:
    """Return the motion of a spider that stands in a world, and its place relative to its feet."""
    angles = np.zeros((1, 4, 24))
    angles[..., [body.JOINTS.index(f"{leg} femur") for leg in lifted]] = np.radians(20)
    motion = Spider(world=world).play(angles)
    feet, centre = motion["feet"][0, 1], motion["centre_of_mass"][0, 1]
    return motion, (feet - centre).astype(float)


@pytest.mark.parametrize(
    ("lifted", "edge", "sign"), [(["L1", "R1"], "L2", -1), (["L4", "R4"], "L3", 1)]
)
def test_a_spider_tips_over_where_gravity_passes_the_edge_of_its_support(
    lifted: list[str], edge: str, sign: int
) -> None:
    """A spider that raises its front feet tips onto them if it faces downhill."""
    _, feet = standing(lifted)
    foot = feet[body.LEGS.index(edge)]
    reach, depth = abs(foot[0]), body.FOOT_RADIUS - foot[2]
    tips = np.degrees(np.arctan(reach / depth))
    for share in (0.9, 0.99):
        motion, _ = standing(lifted, slope=sign * share * tips)
        margin = reach - depth * np.tan(np.radians(share * tips))
        np.testing.assert_allclose(motion["margin"][0], margin, atol=1e-6)
        assert motion["slope"].max() < 1e-3
    motion, _ = standing(lifted, slope=sign * 1.01 * tips)
    assert motion["slope"].min() > 0.05
    assert motion["stance"][0][:, [body.LEGS.index(leg) for leg in lifted]].all()


@pytest.mark.parametrize(("side_slope", "leg"), [(-40.0, "L2"), (40.0, "R2")])
def test_a_side_slope_brings_gravity_closer_to_the_lower_side(side_slope: float, leg: str) -> None:
    motion, feet = standing([], side_slope=side_slope)
    foot = feet[body.LEGS.index(leg)]
    shift = (body.FOOT_RADIUS - foot[2]) * np.tan(np.radians(40.0))
    np.testing.assert_allclose(motion["margin"][0], abs(foot[1]) - shift, atol=1e-6)


def test_a_body_that_turns_above_its_feet_on_a_slope_keeps_its_margin() -> None:
    turns = np.radians(-2.0 * np.arange(91))
    feet = Rotation.from_euler("z", turns[:, None]).as_matrix()[:, None] @ FEET[None, :, :, None]
    result = walked(feet[..., 0], lean=(0.4, 0.3))
    shift = (body.FOOT_RADIUS - FEET[0, 2]) * np.array([0.4, 0.3])
    sides = ConvexHull(FEET[:, :2]).equations
    expected = -(sides[:, :2] @ shift + sides[:, 2]).max()
    # Feet that move on chords are up to 0.02 % closer to the middle than on their circle.
    np.testing.assert_allclose(result["margin"], expected, rtol=5e-4)
    assert result["pose"][-1, 2] == pytest.approx(np.pi, rel=1e-3)


def test_three_feet_in_a_row_on_one_side_are_one_side_of_the_support() -> None:
    feet = np.repeat(FEET[None], 2, axis=0)
    feet[:, :4, 1], feet[:, 4:, 1] = 0.18, -0.17
    # The nearest sides connect the two front feet and the two rear feet.
    assert walked(feet)["margin"] == pytest.approx(0.16)
    feet[:, 4:, 1] = -0.1
    assert walked(feet)["margin"] == pytest.approx(0.1)


def test_two_feet_in_one_place_count_once() -> None:
    feet = np.repeat(FEET[None], 2, axis=0)
    feet[:, 1] = feet[:, 0]
    result = walked(feet)
    assert result["stance"].all()
    sides = ConvexHull(FEET[[0, 2, 3, 4, 5, 6, 7], :2]).equations
    assert result["margin"] == pytest.approx(-sides[:, 2].max(), rel=1e-4)


def test_the_margin_is_the_distance_to_the_hull_of_the_stance_feet() -> None:
    feet, centre = random_poses(100)
    for individual in range(100):
        points = feet[individual, :, :, 0].T.astype(float)
        balance = centre[individual, :, 0].astype(float)
        result = walked(np.repeat(points[None], 2, axis=0), np.repeat(balance[None], 2, axis=0))
        down = points[result["stance"][0]]
        # Compute the plane's normal from the stance feet, and rotate all points to level it.
        _, _, axes = np.linalg.svd(down[:3] - down[:3].mean(axis=0))
        normal = axes[2] * np.sign(axes[2][2])
        if len(down) > 3 or np.arccos(normal[2]) > 0.5:
            continue  # more than three feet are not exactly in one plane
        turn, _ = Rotation.align_vectors([[0, 0, 1]], [normal])
        flat = turn.apply(down)[:, :2]
        middle = turn.apply(balance)[:2]
        edges = ConvexHull(flat).equations
        expected = -(edges[:, :2] @ middle + edges[:, 2]).max()
        np.testing.assert_allclose(result["margin"][0], expected, atol=2e-5)


def test_chunks_and_other_individuals_do_not_change_any_bit() -> None:
    spider = Spider()
    genomes = spider.genome_space().random(7, np.random.default_rng(1))
    whole = spider.move(genomes)
    for index in range(7):
        alone = spider.move(genomes[index : index + 1])
        for channel in spider.channels:
            np.testing.assert_array_equal(alone[channel][0], whole[channel][index])


def test_feet_are_those_of_an_independent_rigid_body_model() -> None:
    pytest.importorskip("mujoco")
    from rigid_body import feet as independent

    spider = Spider()
    motion = spider.move(spider.genome_space().random(2, np.random.default_rng(5)))
    for individual in range(2):
        expected = independent(motion["joint_angles"][individual])
        np.testing.assert_allclose(motion["feet"][individual], expected, atol=2e-7)


def test_skeleton_and_kernels_agree_on_the_feet() -> None:
    spider = Spider(encoding="cpg")
    motion = spider.move(spider.genome_space().random(1, np.random.default_rng(6)))
    points = leg_points(motion["joint_angles"][0], body.Sizes({}))
    np.testing.assert_allclose(points[:, :, 3], motion["feet"][0], atol=2e-7)
    lengths = np.linalg.norm(np.diff(points, axis=2), axis=3)
    np.testing.assert_allclose(
        lengths, np.broadcast_to([body.COXA, body.FEMUR, body.TIBIA], lengths.shape)
    )


def test_the_centre_of_mass_is_the_mean_of_the_segments_middles() -> None:
    spider = Spider()
    motion = spider.move(spider.genome_space().random(1, np.random.default_rng(7)))
    points = leg_points(motion["joint_angles"][0], body.Sizes({}))
    middles = (points[:, :, 1:] + points[:, :, :-1]) / 2
    masses = np.array([body.COXA_MASS, body.FEMUR_MASS, body.TIBIA_MASS])
    centre = np.einsum("flsa,s->fa", middles, masses) / (8 * masses.sum() + body.BODY_MASS)
    np.testing.assert_allclose(motion["centre_of_mass"][0], centre, atol=1e-7)


def test_the_neutral_pose_stands_at_the_published_height() -> None:
    assert pytest.approx(0.0862, abs=5e-5) == body.STANDING_HEIGHT


def test_a_mirrored_gait_gives_a_mirrored_walk() -> None:
    spider = Spider()
    genomes = spider.genome_space().random(5, np.random.default_rng(8))
    groups = np.split(genomes, [24, 32], axis=1)
    sides = np.concatenate(
        [np.roll(group, group.shape[1] // 2, axis=1) for group in groups], axis=1
    )
    pose, mirrored = spider.move(genomes)["pose"], spider.move(sides)["pose"]
    np.testing.assert_allclose(mirrored, pose * [1, -1, -1], atol=1e-4)


@pytest.mark.parametrize("encoding", ["sine", "recurrence"])
def test_the_skeleton_rests_on_the_ground_and_moves_with_the_body(encoding: str) -> None:
    spider = Spider(encoding=encoding)
    motion = spider.move(spider.genome_space().random(2, np.random.default_rng(9)))
    skeleton = spider.skeleton(motion, 1)
    assert skeleton.segments.shape == (300, 28, 2, 3)
    feet = np.sort(skeleton.contacts[:, :, 2])
    np.testing.assert_allclose(feet[:, :3], body.FOOT_RADIUS, atol=1e-6)  # three feet support it
    middle = skeleton.segments[:, :4].mean(axis=(1, 2))
    assert np.abs(middle[:, :2] - motion["pose"][1, :, :2]).max() < 0.03  # the body leans


def test_the_skeleton_leans_as_far_as_the_resting_plane() -> None:
    """The plane of a frame is that of the interval after it, if the joints are still."""
    spider = Spider()
    genomes = spider.genome_space().random(20, np.random.default_rng(3))
    poses = spider.move(genomes)["joint_angles"][:, 7:10]
    motion = spider.play(np.repeat(poses[:, 0:1], 5, axis=1))
    for individual in range(len(genomes)):
        corners = spider.skeleton(motion, individual).segments[0, :4, 0]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        angle = np.arccos(np.abs(normal[2]) / np.linalg.norm(normal))
        assert angle == pytest.approx(motion["slope"][individual, 0], abs=1e-4)


def test_standing_feet_slide_in_a_drawing_as_far_as_in_the_model() -> None:
    spider = Spider()
    motion = spider.move(spider.starts()["tetrapod"][None])
    skeleton = spider.skeleton(motion, 0)
    slid = np.linalg.norm(np.diff(skeleton.contacts[..., :2], axis=0), axis=-1)
    stance = motion["stance"][0]
    drawn = (slid * stance[:-1]).sum(axis=1) / stance[:-1].sum(axis=1)
    np.testing.assert_allclose(drawn, motion["slip"][0, :-1], atol=2e-4)


def test_at_least_three_feet_stand_whichever_four_are_lifted() -> None:
    for lifted in itertools.combinations(range(8), 4):
        feet = np.repeat(FEET[None], 2, axis=0)
        feet[:, list(lifted), 2] += 0.02
        assert walked(feet)["stance"][0].sum() >= 3
