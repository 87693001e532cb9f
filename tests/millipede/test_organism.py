"""The millipede's options, channels, measures and skeleton."""

from itertools import pairwise

import numpy as np
import pytest
from bit_strings import encoded
from pydantic import ValidationError

from gaitsim.contracts import BitSpace
from gaitsim_millipede import cycle
from gaitsim_millipede.codec import CODECS
from gaitsim_millipede.organism import Millipede

SIGNED = CODECS["sign-magnitude"]
BODIES = [
    Millipede(),
    Millipede(codec="unsigned"),
    Millipede(pairs=1),
    Millipede(pairs=8, leg_length=0.2, leg_spacing=0.1, spine=1.0),
]
ANY_BODY = pytest.mark.parametrize("body", BODIES, ids=range(len(BODIES)))


def moved(body, count=10, seed=0):
    return body.move(body.genome_space().random(count, np.random.default_rng(seed)))


def walking(left=20, right=20, **options):
    body = Millipede(**options)
    motion = body.move(encoded(SIGNED, [left] * body.pairs + [right] * body.pairs))
    return body, motion, body.skeleton(motion, 0)


@pytest.mark.parametrize(
    "options",
    [
        {"pairs": 0},
        {"leg_length": 0},
        {"pairs": 3, "leg_spacing": 0.1, "spine": 0.19},
    ],
    ids=str,
)
def test_invalid_bodies_are_refused(options):
    with pytest.raises(ValidationError):
        Millipede(**options)


def test_a_spine_too_short_is_refused_with_the_length_needed():
    with pytest.raises(ValidationError, match=r"0\.16 m"):
        Millipede(pairs=5, spine=0.1)


@pytest.mark.parametrize("pairs", [1, 2, 4, 1000])
def test_the_shortest_possible_spine_is_accepted(pairs):
    for spacing in (0.1, 0.3, 0.07):
        Millipede(pairs=pairs, leg_spacing=spacing, spine=max(pairs - 1, 1) * spacing)


@ANY_BODY
def test_the_genome_has_bits_for_all_left_legs_and_then_all_right_ones(body):
    space = body.genome_space()
    assert isinstance(space, BitSpace)
    bits = 5 if body.codec == "unsigned" else 6
    assert space.genes == 2 * body.pairs * bits
    assert len(set(space.labels)) == space.genes
    legs = [label.split()[0] for label in space.labels[::bits]]
    assert legs == [f"{side}{n + 1}" for side in "LR" for n in range(body.pairs)]
    assert space.contains(space.random(50, np.random.default_rng(0)))


def test_leg_angles_are_those_of_the_genome():
    angles = [20, -20, 7, 0, 1, -13]
    motion = Millipede().move(encoded(SIGNED, angles))
    np.testing.assert_allclose(np.degrees(motion["leg_angles"]), [angles], atol=1e-12)


@ANY_BODY
def test_joints_reach_and_straighten_in_every_cycle(body):
    motion = moved(body)
    swing, lift = motion["joint_angles"][..., ::2], motion["joint_angles"][..., 1::2]
    cycles = swing.reshape(len(swing), cycle.CYCLES, cycle.CYCLE, -1)
    np.testing.assert_array_equal(cycles, np.repeat(cycles[:, :1], cycle.CYCLES, axis=1))
    assert not swing[:, 0].any()
    np.testing.assert_allclose(swing[:, cycle.REACH], motion["leg_angles"], atol=1e-6)
    assert (np.abs(swing) <= np.radians(20) + 1e-6).all()
    # The angles never jump, not even from the end of the cycle to its start.
    assert np.abs(np.diff(np.concatenate([swing, swing[:, :1]], axis=1), axis=1)).max() < 0.05
    assert (lift >= 0).all()
    assert not lift[motion["stance"]].any()
    assert motion["stance"].mean() == 0.5


def test_the_body_moves_while_the_feet_are_on_the_ground():
    body, motion, skeleton = walking(leg_length=0.1)
    x, y, yaw = motion["pose"][0].T
    step = 0.1 * np.sin(np.radians(20))
    np.testing.assert_allclose(x[:: cycle.CYCLE], step * np.arange(cycle.CYCLES), atol=1e-12)
    assert not y.any()
    assert not yaw.any()
    stance = motion["stance"][0, :-1, 0]
    assert not np.diff(x)[~stance].any()
    assert (np.diff(x)[stance] > 0).all()
    # Feet on the ground do not move along the body's path.
    along = np.diff(skeleton.contacts[..., 0], axis=0)
    np.testing.assert_allclose(along[stance], 0, atol=1e-7)
    measures = body.measures(motion)
    assert measures["stride length"].values[0] == pytest.approx(step)
    assert measures["forward"].values[0] == pytest.approx(x[-1])


@pytest.mark.parametrize(("left", "right", "sign"), [(20, -20, -1), (-20, 20, 1)])
def test_a_turn_is_the_difference_of_paths_over_the_distance_of_the_feet(left, right, sign):
    for leg_length in (0.02, 0.5):
        body, motion, _ = walking(left, right, leg_length=leg_length)
        sides = motion["sides"][0]
        yaw = (sides[1] - sides[0]) / (2 * leg_length)
        assert yaw * sign > 0
        assert motion["pose"][0, cycle.CYCLE, 2] == pytest.approx(yaw)
        assert not motion["pose"][..., :2].any()
        assert body.measures(motion)["turn per stride"].values[0] == pytest.approx(np.degrees(yaw))


def test_measures_follow_their_definitions():
    body = Millipede(leg_length=0.2)
    motion = body.move(encoded(SIGNED, [0, 15, 19, 6, 6, 6]))
    measures = {name: measure.values[0] for name, measure in body.measures(motion).items()}
    stride = 0.2 * np.sin(np.radians(6))
    assert measures == pytest.approx(
        {
            "forward": motion["pose"][0, -1, 0],
            "stride length": stride,
            "relative stride": stride / 0.2,
            "turn per stride": 0,
            "left legs": 34 / 3,
            "right legs": 6,
            "crossings": 1,  # L1 and L2 at 0.15 m from the spine; L2 and L3 would meet at 0.54 m
        }
    )


@pytest.mark.parametrize("spacing", [0.04, 0.0342, 0.03, 0.01])
def test_crossing_legs_are_those_whose_segments_meet(spacing):
    body = Millipede(pairs=3, leg_spacing=spacing)
    motion = moved(body, 40, seed=5)
    crossings = body.measures(motion)["crossings"].values
    for angles, counted in zip(motion["leg_angles"].reshape(40, 2, 3), crossings, strict=True):
        met = 0
        for side in angles:
            for front, rear in pairwise(side):
                # rear hip at 0, front hip at `spacing`: s·rear leg = spacing + t·front leg
                lengths = np.array([[np.sin(rear), -np.sin(front)], [np.cos(rear), -np.cos(front)]])
                if abs(np.linalg.det(lengths)) > 1e-12:
                    ways = np.linalg.solve(body.leg_length * lengths, [spacing, 0])
                    met += bool(((ways >= 0) & (ways <= 1)).all())
        assert counted == met
    if spacing > 2 * body.leg_length * np.sin(np.radians(20)):
        assert not crossings.any()
    if spacing == 0.01:
        assert crossings.any()


@ANY_BODY
def test_the_skeleton_has_legs_of_their_length_on_a_spine_that_carries_them(body):
    motion = moved(body, 3)
    skeleton = body.skeleton(motion, 2)
    assert skeleton.names[:2] == ("spine", "L1")
    assert len(skeleton.names) == 1 + 2 * body.pairs
    ends = skeleton.segments[:, :, 1] - skeleton.segments[:, :, 0]
    lengths = np.linalg.norm(ends, axis=2)
    np.testing.assert_allclose(lengths[:, 1:], body.leg_length)
    span = (body.pairs - 1) * body.leg_spacing
    assert (lengths[:, 0] >= span).all()
    np.testing.assert_allclose(lengths[:, 0], body.spine or span + body.leg_spacing)
    hips, middle = skeleton.segments[:, 1:, 0], skeleton.segments[:, :1].mean(axis=2)
    assert (np.linalg.norm(hips - middle, axis=2) <= lengths[:, :1] / 2 + 1e-12).all()


def test_left_is_left_and_the_first_pair_is_in_front():
    _, _, skeleton = walking()
    hips, feet = skeleton.segments[0, 1:, 0], skeleton.contacts[0]
    assert (feet[:3, 1] > 0).all()
    assert (feet[3:, 1] < 0).all()
    assert (np.diff(hips[:3, 0]) < 0).all()
    assert hips[:, 0].sum() == pytest.approx(0)


def test_feet_touch_the_ground_while_the_legs_straighten():
    _, motion, skeleton = walking()
    np.testing.assert_array_equal(skeleton.touching, motion["stance"][0])
    heights = skeleton.contacts[..., 2]
    assert not heights[skeleton.touching].any()
    lifted = heights[np.arange(cycle.FRAMES) % cycle.CYCLE == cycle.REACH // 2]
    assert (lifted > 0.2 * Millipede().leg_length).all()
