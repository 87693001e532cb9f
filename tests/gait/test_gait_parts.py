"""The parts of the gait analysis, compared with results computed by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gaitsim.contracts import Skeleton
from gaitsim.gait import analyse_gait, naming
from gaitsim.gait.feet import Layout, feet_of, fit, wrap
from gaitsim.gait.naming import NEAR, nearest, references
from gaitsim.gait.travel import Slip, heading, lying, slip_of, travel_of, trunk


def contacts(*rows):
    """(frames, feet) of rows of '#' and '.'."""
    return np.array([[sign == "#" for sign in row] for row in rows]).T


def pairs(count):
    """The layout of a number of pairs of legs."""
    return Layout(count, np.repeat([0, 1], count), np.tile(np.arange(count), 2))


def test_steps_are_counted_by_hand():
    touching = contacts("..####..####..####..", "##..####..####..####", "#" * 20)
    (one, two, always), stride = feet_of(touching, ("a", "b", "c"), 10.0)
    assert (one.touch_downs, two.touch_downs) == ((2, 8, 14), (4, 10, 16))
    assert (one.stance, one.swing, one.duty_factor) == pytest.approx((0.4, 0.2, 12 / 20))
    assert (always.touch_downs, always.stance, always.swing) == ((), None, None)
    assert always.duty_factor == 1
    assert not always.steps
    assert (stride.frames, stride.frequency) == (6, pytest.approx(10 / 6))
    assert stride.periodicity > 0.95


def test_chatter_is_not_counted_as_steps():
    clean = np.tile(contacts("..........##########"), (6, 1))
    rough = clean.copy()
    rough[[5, 33, 57, 74]] ^= True
    (foot,), stride = feet_of(rough, ("a",), 20.0)
    (same,), _ = feet_of(clean, ("a",), 20.0)
    assert foot.touch_downs == same.touch_downs
    assert stride.frequency == pytest.approx(1.0)


def test_random_contacts_have_no_stride():
    touching = np.random.default_rng(0).random((300, 6)) < 0.5
    _, stride = feet_of(touching, tuple("abcdef"), 30.0)
    assert stride is None
    assert feet_of(np.ones((5, 2), dtype=bool), ("a", "b"), 30.0)[1] is None
    one_of_three = np.ones((80, 3), dtype=bool)
    one_of_three[:, 0] = contacts("....####" * 10)[:, 0]
    assert feet_of(one_of_three, ("a", "b", "c"), 30.0)[1] is None
    assert feet_of(np.ones((1, 2), dtype=bool), ("a", "b"), 30.0)[1] is None


@given(
    phases=st.lists(st.floats(0, 1), min_size=2, max_size=8),
    shift=st.floats(-2, 2),
    seed=st.integers(0, 99),
)
def test_the_nearest_shift_is_found(phases, shift, seed):
    one = np.array(phases)
    other = np.random.default_rng(seed).random(len(one))
    distance, shifted = fit(one, other)
    tried = np.linspace(0, 1, 2000)[:, None]
    by_force = np.sqrt((wrap(one - other - tried) ** 2).mean(axis=1)).min()
    assert distance <= by_force + 1e-12
    assert distance == pytest.approx(by_force, abs=1e-3)
    assert np.sqrt((wrap(one - shifted) ** 2).mean()) == pytest.approx(distance, abs=1e-9)
    assert fit(one + shift, other)[0] == pytest.approx(distance, abs=1e-6)
    assert fit(one + shift, one)[0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("count", range(1, 11))
def test_reference_gaits_are_apart_and_found(count):
    known = references(pairs(count))
    for name, pattern in known.items():
        found, distances = nearest((pattern + 0.3) % 1, pairs(count))
        assert found.name == name
        assert distances[name] == pytest.approx(0, abs=1e-9)
        assert all(distances[other] > NEAR for other in known if other != name)
    names = {1: "alternating steps", 2: "trot", 3: "alternating tripod", 4: "alternating tetrapod"}
    assert names.get(count, f"alternating, {2 * count} legs") in known


def test_the_tetrapod_is_that_of_barth():
    legs = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
    phases = dict(zip(legs, references(pairs(4))["alternating tetrapod"], strict=True))
    assert {phases[leg] for leg in ("R4", "L3", "R2", "L1")} == {0.0}
    assert {phases[leg] for leg in ("L4", "R3", "L2", "R1")} == {0.5}


def test_four_legs_walk_trot_pace_and_bound():
    # LF LH RF RH; in a lateral-sequence walk LH, LF, RH, RF come down in turn.
    for name, phases in {
        "lateral-sequence walk": [0.25, 0, 0.75, 0.5],
        "diagonal-sequence walk": [0.75, 0, 0.25, 0.5],
        "trot": [0, 0.5, 0.5, 0],
        "pace": [0, 0, 0.5, 0.5],
        "bound": [0, 0.5, 0, 0.5],
        "in-phase": [0.2] * 4,
    }.items():
        assert nearest(np.array(phases), pairs(2))[0].name == name


def test_the_heading_is_the_spiders_yaw(spider):
    organism = spider.organism
    genomes = organism.genome_space().random(3, np.random.default_rng(4))
    motion = organism.move(genomes)
    for index in range(3):
        turned = heading(trunk(organism.skeleton(motion, index)))
        # Leaning by an angle changes the heading by the square of the angle.
        assert turned == pytest.approx(motion["pose"][index, :, 2], abs=2e-3)


def test_a_body_that_pitches_over_has_no_heading():
    pitch = np.linspace(0, np.pi, 40)[:, None]
    x, z = np.array([1.0, 1, -1, -1]), np.array([0.1, -0.1, 0.1, -0.1])
    forward, up = np.cos(pitch) * x + np.sin(pitch) * z, np.cos(pitch) * z - np.sin(pitch) * x
    body = np.stack([forward, np.broadcast_to([0.1, -0.1, -0.1, 0.1], up.shape), up], axis=-1)
    assert heading(body) is None
    assert heading(body[:15]) == pytest.approx(np.zeros(15), abs=1e-9)


def walking(speed, frames=11, rate=10.0):
    """A rod of 1 m, 0.5 m above the ground, that goes along x; two feet touch down and lift off."""
    path = np.zeros((frames, 3))
    path[:, 0], path[:, 2] = speed * np.arange(frames) / rate, 0.5
    rod = path[:, None] + np.array([[0.5, 0, 0], [-0.5, 0, 0]])
    feet = np.zeros((frames, 2, 3))
    feet[:, :, 1] = [0.2, -0.2]
    down = np.arange(frames)[:, None] // 4 % 2 == [0, 1]
    return Skeleton(rod[:, None], ("rod",), rate, feet, down, ("left", "right"), path)


def test_travel_is_measured():
    travel = travel_of(walking(2.0), np.array([[0.0, 0], [1, -1], [0, 0]] + [[0, 0]] * 8))
    assert (travel.seconds, travel.forward, travel.path) == pytest.approx((1.0, 2.0, 2.0))
    assert (travel.speed, travel.straightness, travel.height) == pytest.approx((2, 1, 0.5))
    assert travel.froude == pytest.approx(4 / (9.81 * 0.5))
    assert travel.joint_travel == pytest.approx(4 / 2.0)
    assert (travel.yaw, travel.deviation, travel.lateral, travel.climb) == (0, 0, 0, 0)
    assert travel_of(walking(0.0), None).straightness is None


def test_a_body_on_the_ground_has_no_froude_number():
    skeleton = walking(1.0)
    assert lying(skeleton) == 0
    flat = np.array([1, 1, 0])
    skeleton = replace(skeleton, segments=skeleton.segments * flat, centre=skeleton.centre * flat)
    assert lying(skeleton) == 1
    assert travel_of(skeleton, None).froude is None


def test_slip_is_the_slide_of_standing_feet():
    skeleton = walking(1.0)
    feet, path = skeleton.contacts.copy(), skeleton.centre
    assert slip_of(feet, skeleton.touching, path, feet - path[:, None]) == Slip(0, 0, 0)
    feet[:, :, 0] = path[:, :1]  # dragged along
    slip = slip_of(feet, skeleton.touching, path, feet - path[:, None])
    assert (slip.distance, slip.ratio) == pytest.approx((1, 1))
    assert slip.share is None
    down = np.ones_like(skeleton.touching)
    feet[:, 1, 0] = 0  # the mean of one that is and one that is not
    assert slip_of(feet, down, path, feet - path[:, None]).distance == pytest.approx(0.5)


def test_feet_that_flicker_are_flagged():
    steady = contacts("....####" * 10)
    fast = contacts("#." * 40)
    two = contacts("##.." * 20)
    assert naming.flickering(steady, ("a",), 30.0) is None
    for touching in (fast, two):
        flag = naming.flickering(np.hstack([touching, steady]), ("a", "b"), 30.0)
        assert flag.name == "flickering feet"
        assert flag.seen.startswith("a touch down or lift off")


def test_unsupported_travel_is_flagged():
    path = np.zeros((11, 3))
    path[:, 0] = np.arange(11)
    margin = np.where(np.arange(11) < 4, -0.01, 0.01)
    assert "40 % of the path" in naming.unsupported(margin, path, 0.0).seen
    assert naming.unsupported(margin, path, 0.5) is None  # it lies on its belly
    assert naming.unsupported(np.abs(margin), path, 0.0) is None
    assert naming.unsupported(margin, path * 0, 0.0) is None


def test_the_analysis_of_a_body_without_feet_names_the_missing_results():
    skeleton = walking(2.0)
    gait = analyse_gait(
        Skeleton(skeleton.segments, skeleton.names, skeleton.frame_rate, centre=skeleton.centre)
    )
    assert gait.footfalls is None
    assert (gait.name.name, gait.name.reason) == ("none", "the body has no feet")
    assert gait.travel.speed == pytest.approx(2)
    (missing,) = gait.missing
    assert "no contacts" in missing
    # Flipping limbs are flagged only if joints are commanded in every frame.
    flips = np.zeros((20, 1, 2, 3))
    flips[::2, 0, 1, 2] = flips[:, 0, 1, 0] = 1
    body = Skeleton(flips, ("arm",), 30.0, centre=np.zeros((20, 3)))
    assert [flag.name for flag in analyse_gait(body, flips[:, 0, 1]).flags] == ["flip-flop"]
    assert analyse_gait(body).flags == ()


def hopping(flight, stride, count):
    """Contacts of two feet that fly together, (frames, 2), and a path at 1 m/s, 100 frames a s."""
    foot = np.tile(np.arange(stride) >= flight, count)
    path = np.zeros((len(foot), 3))
    path[:, 0] = np.arange(len(foot)) / 100
    return np.stack([foot, foot], axis=1), path


def test_a_single_flight_is_a_leap_and_a_running_gait_is_none():
    touching, path = hopping(50, 100, 1)
    (flag,) = [naming.leap(touching, path, 0.3, 100.0)]
    assert flag.seen == "one flight of 0.50 s covers 0.50 m, 51 % of the path"
    assert naming.leap(touching, path, 1.1, 100.0) is None  # shorter than half of the body
    assert naming.leap(*hopping(50, 100, 4), 0.3, 100.0) is None
    assert naming.leap(*hopping(0, 100, 1), 0.3, 100.0) is None
    assert naming.leap(touching, 0 * path, 0.3, 100.0) is None


def test_a_body_whose_feet_carry_little_of_its_weight_is_not_on_its_feet():
    bouncing = 1 + np.sin(np.linspace(0, 20 * np.pi, 500))
    assert naming.not_on_feet(bouncing) is None
    assert "carry only 30 %" in naming.not_on_feet(0.3 * bouncing).seen


def test_a_body_in_physics_is_analysed_until_it_falls():
    """It walks on two feet for 1 s, 0.5 m at 50 frames a second, and then lies where it fell."""
    frames, upright = 101, 51
    x = np.minimum(np.arange(frames), upright - 1) / 100
    centre = np.stack([x, 0 * x, 0 * x + 0.3], axis=1)
    box = np.array([[[0.1, 0.1, 0], [-0.1, 0.1, 0]], [[0.1, -0.1, 0], [-0.1, -0.1, 0]]])
    feet = centre[:, None] + [[0, 0.1, -0.3], [0, -0.1, -0.3]]
    carried = np.where(np.arange(frames) < upright, 1.0, 0.0)
    body = Skeleton(
        centre[:, None, None] + box,
        ("left", "right"),
        50.0,
        contacts=feet,
        touching=np.repeat(carried[:, None] > 0, 2, axis=1),
        contact_names=("L1", "R1"),
        centre=centre,
    )
    measured = {"lasted": 1.0, "cost of transport": 0.7}
    gait = analyse_gait(body, dynamic=True, measured=measured, carried=carried)
    assert gait.travel.speed == pytest.approx(0.5)
    assert (gait.travel.cost_of_transport, gait.travel.lasted) == (0.7, 1.0)
    assert not {flag.name for flag in gait.flags} & {"leap", "not on its feet"}
    assert [foot.duty_factor for foot in gait.footfalls.feet] == [1.0, 1.0]
    at_once = analyse_gait(body, dynamic=True, measured={"lasted": 0.0}, carried=carried)
    assert at_once.name.name == "standing"
    whole = analyse_gait(body, dynamic=True, carried=carried)
    assert "not on its feet" in {flag.name for flag in whole.flags}
    assert whole.travel.speed == pytest.approx(0.25)
