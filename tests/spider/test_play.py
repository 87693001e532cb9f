import math

import numpy as np
import pytest

from gaitsim_spider.encodings import ENCODINGS
from gaitsim_spider.organism import Spider

STEP, LIMIT = math.radians(5), math.radians(30)


def gait(angles):
    """Return a gait, (1, frames, 24), in which all joints have the same angles, (frames,)."""
    return np.repeat(np.asarray(angles, dtype=float)[None, :, None], 24, axis=2)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_playing_the_angles_of_a_genome_gives_the_same_bits(encoding):
    spider = Spider(encoding=encoding)
    moved = spider.move(spider.genome_space().random(5, np.random.default_rng(0)))
    given = moved["joint_angles"].astype(np.float64)
    kept = given.copy()
    played = spider.play(given)
    for channel in spider.channels:
        assert np.array_equal(moved[channel], played[channel]), channel
    assert played.frame_rate == moved.frame_rate
    assert np.array_equal(given, kept)
    assert np.array_equal(spider.skeleton(played, 2).segments, spider.skeleton(moved, 2).segments)


def test_angles_beyond_thirty_degrees_are_clipped():
    played = Spider().play(gait([1.0, 1.0, -0.4]))["joint_angles"]
    assert played[0, :2] == pytest.approx(LIMIT, abs=1e-6)
    assert np.abs(played).max() <= np.float32(LIMIT)


def test_a_joint_turns_at_most_five_degrees_per_frame():
    # Like a servo, it lags behind a jump and then catches up.
    asked = [0.0, 3 * STEP, 3 * STEP, 3 * STEP, 2.5 * STEP]
    played = Spider().play(gait(asked))["joint_angles"][0, :, 7]
    assert played == pytest.approx(np.array([0, 1, 2, 3, 2.5]) * STEP, abs=1e-6)


@pytest.mark.parametrize("shape", [(300, 24), (1, 1, 24), (1, 300, 23)])
def test_other_shapes_are_refused(shape):
    with pytest.raises(ValueError, match=r"expected \(population, frames, joints\)"):
        Spider().play(np.zeros(shape))


def test_angles_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="not finite"):
        Spider().play(gait([0.0, math.nan, 0.0]))
