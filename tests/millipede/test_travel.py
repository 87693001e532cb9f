"""The four motions, and the fitness in each direction, against the source's closed forms."""

import numpy as np
import pytest
from bit_strings import encoded
from hypothesis import given, settings, strategies as st

from gaitsim.contracts import Motion
from gaitsim_millipede.codec import CODECS
from gaitsim_millipede.fitness import MillipedeTravel, clockwise_motion, forward_motion
from gaitsim_millipede.organism import Millipede

SIGNED = CODECS["sign-magnitude"]
DIRECTIONS = ("forward", "backward", "clockwise", "counter-clockwise")
ANGLES = st.integers(-20, 20)
EXAMPLES = settings(max_examples=80)


def closed_form(left, right):
    """Return the kind and size of the motion by the source's formulas; backward is negative."""
    if left > 0 and right > 0:
        return "forward", min(left, right)
    if left < 0 and right < 0:
        return "backward", max(left, right)
    if left > 0 > right:
        return "clockwise", left - right
    if left < 0 < right:
        return "counter-clockwise", right - left
    return "none", 0.0


def scores(motion):
    return {
        direction: float(MillipedeTravel(direction=direction).terms(motion)["travel"][0])
        for direction in DIRECTIONS
    }


@pytest.mark.parametrize(
    ("left", "right", "moved", "turned"),
    [
        (0.2, 0.1, 0.1, 0),
        (0.1, 0.2, 0.1, 0),
        (-0.2, -0.1, -0.1, 0),
        (-0.1, -0.2, -0.1, 0),
        (0.1, -0.2, 0, 0.3),
        (-0.1, 0.2, 0, -0.3),
        (0, 0, 0, 0),
        (0.1, 0, 0, 0),
        (0, 0.1, 0, 0),
        (-0.1, 0, 0, 0),
        (0, -0.1, 0, 0),
    ],
)
def test_two_sides_make_one_motion(left, right, moved, turned):
    sides = np.array([[left, right]])
    assert forward_motion(sides)[0] == pytest.approx(moved)
    assert clockwise_motion(sides)[0] == pytest.approx(turned)


@EXAMPLES
@given(
    angles=st.integers(1, 6).flatmap(lambda n: st.lists(ANGLES, min_size=2 * n, max_size=2 * n)),
    leg_length=st.floats(0.001, 10),
)
def test_any_gait_moves_and_scores_by_the_closed_forms(angles, leg_length):
    pairs = len(angles) // 2
    motion = Millipede(pairs=pairs, leg_length=leg_length).move(encoded(SIGNED, angles))
    steps = leg_length * np.sin(np.radians(angles))
    # As in an exact sum, legs that cancel leave exactly 0.
    left, right = (
        0.0 if abs(side) < 1e-12 * leg_length else side
        for side in (steps[:pairs].mean(), steps[pairs:].mean())
    )
    np.testing.assert_allclose(motion["sides"], [[left, right]], atol=1e-12 * leg_length)
    kind, size = closed_form(left, right)
    most = leg_length * np.sin(np.radians(20))
    expected = dict.fromkeys(DIRECTIONS, 0.0)
    if kind in ("forward", "backward"):
        expected["forward"] = 10 * size / most
        expected["backward"] = -expected["forward"]
    elif kind != "none":
        expected[kind] = 10 * size / (2 * most)
        (opposite,) = {"clockwise", "counter-clockwise"} - {kind}
        expected[opposite] = -expected[kind]
    assert scores(motion) == pytest.approx(expected, abs=1e-10)


@EXAMPLES
@given(
    pairs=st.integers(1, 1000),
    codec=st.sampled_from(["sign-magnitude", "unsigned"]),
    leg_length=st.floats(0.001, 10),
)
def test_the_optimum_is_20_degrees_for_every_leg_and_scores_10(pairs, codec, leg_length):
    body = Millipede(pairs=pairs, codec=codec, leg_length=leg_length)
    best = encoded(CODECS[codec], [20] * (2 * pairs))
    assert body.genome_space().contains(best)
    motion = body.move(best)
    assert scores(motion)["forward"] == 10
    assert motion["sides"] == pytest.approx(leg_length * np.sin(np.radians(20)))
    # A smaller angle of a single leg lowers the score.
    lesser = best.copy()
    lesser[0, -3] = 0  # the last leg reaches 16°
    assert scores(body.move(lesser))["forward"] < 10


@pytest.mark.parametrize("pairs", [1, 3, 50])
@pytest.mark.parametrize(
    ("direction", "left", "right"),
    [
        ("forward", 20, 20),
        ("backward", -20, -20),
        ("clockwise", 20, -20),
        ("counter-clockwise", -20, 20),
    ],
)
def test_each_direction_has_its_optimum_of_10(pairs, direction, left, right):
    motion = Millipede(pairs=pairs).move(encoded(SIGNED, [left] * pairs + [right] * pairs))
    assert scores(motion)[direction] == 10
    assert sorted(scores(motion).values()) == [-10, 0, 0, 10]


def test_no_score_exceeds_10():
    sides = np.random.default_rng(0).uniform(-1, 1, (1000, 2))
    for direction in DIRECTIONS:
        terms = MillipedeTravel(direction=direction).terms(Motion(30.0, {"side_reach": sides}))
        assert list(terms) == ["travel"]
        assert (np.abs(terms["travel"]) <= 10).all()


@pytest.mark.parametrize("left", [[1, 2, 3, -1, -2, -3], [20, 7, 1, -7, -20, -1], [5, -5] * 3])
def test_legs_that_cancel_leave_a_side_exactly_at_rest(left):
    """A rounding error of one side would be a turn if the other side is at full reach."""
    for right in (-20, 20):
        body = Millipede(pairs=6)
        motion = body.move(encoded(SIGNED, left + [right] * 6))
        assert motion["side_reach"][0, 0] == 0
        assert set(scores(motion).values()) == {0.0}
        assert not motion["pose"].any()


def test_the_unsigned_codec_never_moves_backward():
    body = Millipede(codec="unsigned")
    space = body.genome_space()
    motion = body.move(space.random(500, np.random.default_rng(1)))
    for direction, highest in zip(DIRECTIONS, (10, 0, 0, 0), strict=True):
        travel = MillipedeTravel(direction=direction).terms(motion)["travel"]
        assert travel.max() <= highest
    assert not clockwise_motion(motion["side_reach"]).any()
