"""Tests of the independent simulation, which other tests use to evaluate gaits."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from rigid_body import LEGS, VARIANTS, WEIGHT, Replay, feet, replay, tetrapod


@pytest.fixture(scope="module")
def standing() -> Replay:
    return replay(np.zeros((300, 24)))


def test_feet_of_the_neutral_pose_stand_where_the_lengths_put_them() -> None:
    place = feet(np.zeros(24))[0]
    reach = 0.03 + 0.08 * np.cos(np.radians(30)) + 0.12 * np.cos(np.radians(80))
    azimuth = np.radians([45, 15, -15, -45])
    np.testing.assert_allclose(
        place[:4, 0], [0.075, 0.025, -0.025, -0.075] + reach * np.sin(azimuth)
    )
    np.testing.assert_allclose(place[:4, 1], 0.07 + reach * np.cos(azimuth))
    np.testing.assert_allclose(place[:4] * [1, -1, 1], place[4:], atol=1e-12)
    np.testing.assert_allclose(place[:, 2], 0.008 - 0.0862, atol=5e-5)


@pytest.mark.parametrize("leg", range(8), ids=LEGS)
def test_positive_angles_swing_forward_lift_and_extend(leg: int) -> None:
    poses = np.zeros((4, 24))
    poses[[1, 2, 3], [3 * leg, 3 * leg + 1, 3 * leg + 2]] = 0.1
    neutral, swung, lifted, extended = feet(poses)[:, leg]
    hip = np.array([[0.075, 0.025, -0.025, -0.075][leg % 4], 0.07 if leg < 4 else -0.07])
    assert swung[0] > neutral[0] + 0.005
    assert lifted[2] > neutral[2] + 0.005
    assert np.linalg.norm(extended[:2] - hip) > np.linalg.norm(neutral[:2] - hip) + 0.005


def test_a_standing_body_stays_at_the_standing_height(standing: Replay) -> None:
    assert np.abs(standing.path[:, :2]).max() < 1e-3
    assert abs(standing.yaw) < 0.01
    # Servos sag, and feet sink into the floor.
    np.testing.assert_allclose(standing.path[:, 2], 0.0862, atol=1e-3)
    assert not standing.fell


def test_the_feet_at_rest_carry_the_weight(standing: Replay) -> None:
    np.testing.assert_allclose(standing.load.sum(axis=1), WEIGHT, rtol=1e-3)
    assert standing.load[:, 8].max() == 0
    np.testing.assert_allclose(standing.duty, 1)


@pytest.mark.sampled
@pytest.mark.parametrize("variant", VARIANTS)
def test_a_hand_made_tetrapod_walks_straight(variant: str) -> None:
    walk = replay(tetrapod(), **VARIANTS[variant])
    assert 1.6 < walk.forward < 2.1
    assert abs(walk.lateral) < 0.1
    assert abs(walk.yaw) < 5
    assert max(walk.max_roll, walk.max_pitch) < 5
    assert not walk.fell
    assert walk.belly == 0


def test_lifting_all_legs_is_a_fall() -> None:
    gait = np.zeros((60, 8, 3))
    gait[20:, :, 1:] = np.radians(30)
    drop = replay(gait.reshape(60, 24))
    assert drop.fell
    assert drop.min_height < 0.032
    assert drop.belly > 0.5
