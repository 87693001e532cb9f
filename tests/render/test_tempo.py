import numpy as np
import pytest

from gaitsim.contracts import Skeleton
from gaitsim.render.encoder import (
    ENOUGH,
    default_speed,
    format_speed,
    is_resolved,
    movement_frequency,
)


def flapping(frequency, frame_rate=1000.0, seconds=2.0, drift=0.3):
    """Return a body with two wings that climbs and drifts."""
    times = np.arange(0, seconds, 1 / frame_rate)
    segments = np.zeros((len(times), 2, 2, 3))
    segments[:, 0, 1, 1], segments[:, 1, 1, 1] = 0.5, -0.5
    segments[:, :, 1, 2] = 0.3 * np.sin(2 * np.pi * frequency * times)[:, None]
    segments[..., 0] += drift * times[:, None, None]
    segments[..., 2] += 4 * times[:, None, None] ** 2
    return Skeleton(segments, ("L", "R"), frame_rate, centre=segments[:, 0, 0])


@pytest.mark.parametrize("frequency", [0.8, 3.0, 12.0, 25.0, 49.0])
def test_the_frequency_is_that_of_the_wing_beat(frequency):
    assert movement_frequency(flapping(frequency, seconds=5.0)) == pytest.approx(frequency, abs=0.3)


@pytest.mark.parametrize("frames", [1, 2, 40])
def test_a_body_that_does_not_move_about_its_path_has_frequency_0(frames):
    segments = np.tile(np.eye(2, 3), (frames, 1, 1, 1)) + np.arange(frames)[:, None, None, None]
    assert movement_frequency(Skeleton(segments, ("a",), 30.0)) == 0


@pytest.mark.parametrize("rate", [10, 25, 30, 60])
@pytest.mark.parametrize("frequency", [0.0, 1.5, 3.7, 8.0, 25.0, 49.0])
def test_slow_motion_shows_each_beat_and_is_not_slower_than_needed(frequency, rate):
    speed = default_speed(frequency, rate, 0.01)
    assert is_resolved(frequency, rate, speed)
    if speed < 1:
        assert not is_resolved(frequency, rate, 1)
        assert ENOUGH <= rate / (frequency * speed) < 2 * ENOUGH


def test_no_motion_is_slower_than_allowed():
    assert default_speed(1e9, 30, 0.01) == 1 / 64


@pytest.mark.parametrize(
    ("speed", "words"),
    [(0.5, "½ speed"), (0.125, "⅛ speed"), (1 / 16, "1/16 speed"), (0.1, "1/10 speed"),
     (0.3, "0.3 × speed"), (4, "4 × speed")],
)  # fmt: skip
def test_speeds_are_formatted(speed, words):
    assert format_speed(speed) == words
