"""Stability margins, compared with polygons computed by hand and with the spider's own."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.gait import stability_margin
from gaitsim.gait.feet import half_way

SQUARE = [(1, 1), (-1, 1), (-1, -1), (1, -1)]


def standing(feet, centre, touching=None, frames=1):
    """A body that stands still on feet at (x, y), seen from above."""
    places = np.zeros((frames, len(feet), 3))
    places[:, :, :2] = feet
    down = np.ones(len(feet), dtype=bool) if touching is None else np.array(touching)
    return Skeleton(
        segments=np.zeros((frames, 1, 2, 3)),
        names=("body",),
        frame_rate=10.0,
        contacts=places,
        touching=np.tile(down, (frames, 1)),
        centre=np.tile([*centre, 1.0], (frames, 1)),
    )


@pytest.mark.parametrize(
    ("feet", "centre", "margin"),
    [
        (SQUARE, (0, 0), 1),
        (SQUARE, (0.75, 0.5), 0.25),
        (SQUARE, (1, 0), 0),
        (SQUARE, (1.5, 0), -0.5),
        (SQUARE, (4, 5), -5),  # 3-4-5 from the corner, not 4 from an edge's line
        ([*SQUARE, (0.2, 0.1)], (0, 0), 1),  # a foot within changes nothing
        ([*SQUARE, (1, 0), (1, 1)], (0, 0), 1),  # nor one on an edge, nor two in one place
        ([(0, 0), (4, 0), (0, 3)], (1, 1), 1),  # the inscribed circle's radius
        ([(0, 0), (2, 0.5)], (1, 0.25), 0),  # two feet: a line, on which it balances
        ([(0, 0), (2, 1), (4, 2)], (0, 5), -np.hypot(0, 5) * np.cos(np.arctan(0.5))),
        ([(0, 0)], (3, 4), -5),
    ],
)
def test_margins_of_hand_made_polygons(feet, centre, margin):
    for turn in (0.0, 0.4, 3.0):
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        there = np.array([5.0, -7.0])
        skeleton = standing(
            np.array(feet) @ turned.T + there, np.array(centre) @ turned.T + there, frames=2
        )
        assert stability_margin(skeleton) == pytest.approx([margin] * 2, abs=1e-9)


def test_a_planar_body_cannot_tip_sideways():
    feet = [(0.5, 0), (-0.3, 0), (0.1, 0)]
    assert stability_margin(standing(feet, (0.1, 0))) == pytest.approx([0.4])
    assert stability_margin(standing(feet, (0.7, 0))) == pytest.approx([-0.2])


def test_the_margin_is_computed_half_way_to_the_next_frame():
    skeleton = standing(SQUARE, (0, 0), frames=3)
    skeleton.centre[:, 0] = [0, 0.2, 0.6]
    assert stability_margin(skeleton) == pytest.approx([0.9, 0.6, 0.6])
    assert half_way(np.array([[1.0], [2.0]])).tolist() == [[1.5], [1.5]]
    assert half_way(np.array([[1.0]])).tolist() == [[1.0]]


def test_a_body_without_feet_has_no_margin():
    with pytest.raises(GaitsimError, match="without feet"):
        stability_margin(Skeleton(np.zeros((2, 1, 2, 3)), ("body",), 1.0))


def test_the_spiders_own_margin_is_the_same():
    from gaitsim.experiment import load_experiment

    for preset, seed in (("spider", 1), ("spider-recurrence", 2)):
        organism = load_experiment(preset).organism
        motion = organism.move(organism.genome_space().random(6, np.random.default_rng(seed)))
        for index in range(6):
            own = motion["margin"][index].astype(float)
            skeleton = replace(organism.skeleton(motion, index), touching=motion["stance"][index])
            margin = stability_margin(skeleton)
            # The body measures in the middle of an interval, the skeleton between two frames that
            # may rest on different feet. Beyond a corner, the body measures the distance from the
            # lines through the edges.
            within = own > 0
            assert within.any()
            error = np.abs(margin - own)[within]
            assert np.median(error) < 3e-4
            assert np.quantile(error, 0.9) < 3e-3
            clear = np.abs(own) > 0.01
            assert clear.any()
            assert (np.sign(margin) == np.sign(own))[clear].all()
