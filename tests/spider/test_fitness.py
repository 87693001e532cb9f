import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from gaitsim.contracts import Motion
from gaitsim_spider.body import time_second
from gaitsim_spider.classic import SpiderClassic
from gaitsim_spider.organism import Spider
from gaitsim_spider.walk import SpiderWalk

SPIDER = Spider()


def moved(spider: Spider = SPIDER, count: int = 20) -> Motion:
    return spider.move(spider.genome_space().random(count, np.random.default_rng(0)))


def test_walk_terms_follow_their_definitions() -> None:
    motion = moved()
    terms = SpiderWalk(safe_margin=0.03, support_weight=3, yaw_weight=1).terms(motion)
    pose = motion["pose"].astype(float)
    np.testing.assert_allclose(terms["forward"], pose[:, -1, 0])
    np.testing.assert_allclose(
        terms["support"], -3 * (motion["margin"] < np.float32(0.03)).mean(axis=1)
    )
    np.testing.assert_allclose(terms["drift"], -np.abs(pose[:, :, 1]).mean(axis=1))
    np.testing.assert_allclose(terms["yaw"], -np.sqrt((pose[:, :, 2] ** 2).mean(axis=1)))


@pytest.mark.parametrize(
    ("weight", "term"),
    [
        ("slip_weight", "slip"),
        ("drift_weight", "drift"),
        ("yaw_weight", "yaw"),
        ("slope_weight", "slope"),
        ("support_weight", "support"),
        ("vibration_weight", "vibration"),
        ("jerk_weight", "jerk"),
    ],
)
def test_every_weight_scales_its_term_and_no_other(weight: str, term: str) -> None:
    motion = moved(count=5)
    standard = SpiderWalk()
    doubled = standard.model_copy(update={weight: 2 * getattr(standard, weight)}).terms(motion)
    for name, values in standard.terms(motion).items():
        np.testing.assert_allclose(doubled[name], values * (2 if name == term else 1))
        if name != "forward":
            assert (values <= 0).all()


def test_vibration_and_jerk_agree_with_scipy() -> None:
    angles = np.random.default_rng(1).normal(0, 0.1, (4, 24, 300)).astype(np.float32)
    channels = {**moved(count=4), "joint_angles": time_second(angles)}
    terms = SpiderWalk(vibration_weight=1, jerk_weight=1).terms(Motion(30.0, channels))
    vibration, jerk = -terms["vibration"], -terms["jerk"] / 30**3
    reference = sosfilt(butter(4, 5.0, "high", fs=30.0, output="sos"), angles - angles[:, :, :1])
    np.testing.assert_allclose(vibration, np.sqrt((reference**2).mean(axis=(1, 2))), rtol=1e-5)
    third = np.diff(angles.astype(float), 3, axis=2)
    np.testing.assert_allclose(jerk, np.sqrt((third**2).mean(axis=(1, 2))), rtol=1e-5)


def test_a_flip_flop_scores_below_standing_still() -> None:
    """The flip-flop is the only lasting motion of the recurrence."""
    flips = Spider(encoding="recurrence")
    genomes = np.zeros((2, 48))
    genomes[0, ::2], genomes[0, 1::2] = -2.0, 0.08  # every joint flips between 0 and 0.08
    scores = sum(SpiderWalk().terms(flips.move(genomes)).values())
    assert scores[0] < -0.5 < scores[1]


def test_classic_terms_against_plain_numpy() -> None:
    motion = moved(Spider(encoding="recurrence"))
    fitness = SpiderClassic()
    terms = fitness.terms(motion)
    feet = motion["feet"].astype(float)
    angles = motion["joint_angles"].astype(float)
    path = np.abs(np.diff(feet[..., 0], axis=1)).sum(axis=1)
    np.testing.assert_allclose(terms["movement"], path.mean(axis=1), rtol=1e-4)
    np.testing.assert_allclose(terms["low movement"], -10 * (path < 0.1).mean(axis=1))
    height = feet[..., 2] - (0.008 - 0.0861817)
    band = np.abs(height) <= 0.01
    np.testing.assert_allclose(terms["band"], 2 * band.mean(axis=(1, 2)), atol=0.01)
    depth = np.maximum(-height, 0).mean(axis=(1, 2))
    np.testing.assert_allclose(terms["penetration"], -50 * depth, atol=1e-3)
    variance = np.array(
        [
            np.mean([row[on].var() if on.any() else 0.0 for row, on in zip(h, b, strict=True)])
            for h, b in zip(height, band, strict=True)
        ]
    )
    np.testing.assert_allclose(terms["variance"], -2000 * variance, atol=2e-3)
    beyond = np.maximum(np.abs(angles[:, :, ::3]) - np.radians(20), 0).mean(axis=(1, 2))
    np.testing.assert_allclose(terms["overlapping legs"], -20 * beyond, rtol=1e-4, atol=1e-6)
    change = (np.diff(angles, axis=1) ** 2).mean(axis=(1, 2))
    np.testing.assert_allclose(terms["angle change"], -50 * change, rtol=1e-4, atol=1e-7)


def test_classic_prefers_moving_to_standing_still() -> None:
    """Without its penalty, standing still was a local optimum in the source."""
    still, waving = np.zeros((2, 48))
    waving[:24:3] = 0.2
    terms = SpiderClassic().terms(SPIDER.move(np.array([still, waving])))
    score = sum(terms.values())
    assert score[1] > score[0]


def test_fewer_legs_than_the_minimum_must_move() -> None:
    motion = moved(Spider(encoding="recurrence"))
    path = np.abs(np.diff(motion["feet"][..., 0].astype(float), axis=1)).sum(axis=1)
    threshold = float(np.median(path))
    moving = (path >= threshold).sum(axis=1)
    assert len(np.unique(moving)) > 1
    for least in (1, 4, 8):
        fitness = SpiderClassic(moving_legs=least, low_movement=threshold)
        found = fitness.terms(motion)["low movement"]
        np.testing.assert_allclose(found, -10 * np.maximum(least - moving, 0) / least)
