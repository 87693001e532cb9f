"""Damaged spiders against plain NumPy, an independent reference and their mirror images."""

import numpy as np
import pytest
import reference

from gaitsim_spider import body
from gaitsim_spider.organism import Spider

GENOMES = Spider().genome_space().random(3, np.random.default_rng(4))
INTACT = Spider().move(GENOMES)


def damaged(*damage: str) -> Spider:
    return Spider(damage=damage)


def mirrored(genomes: np.ndarray) -> np.ndarray:
    groups = np.split(genomes, [24, 32], axis=1)
    return np.concatenate([np.roll(group, group.shape[1] // 2, axis=1) for group in groups], axis=1)


def test_damage_does_not_change_other_joints() -> None:
    spider = damaged("L2 lost", "R1 femur stuck 20", "R3 tibia stuck", "R4 coxa slow 0.25")
    angles = spider.move(GENOMES)["joint_angles"]
    index = {name: n for n, name in enumerate(body.JOINTS)}
    expected = INTACT["joint_angles"].copy()
    expected[:, :, 3:6] = 0
    expected[:, :, index["R1 femur"]] = np.radians(20)
    expected[:, :, index["R3 tibia"]] = 0
    slow = index["R4 coxa"]
    steps = np.abs(np.diff(angles[:, :, slow], axis=1))
    assert steps.max() == pytest.approx(np.radians(1.25), abs=1e-6)
    expected[:, :, slow] = angles[:, :, slow]
    np.testing.assert_array_equal(angles, expected)


@pytest.mark.sampled
@pytest.mark.parametrize(
    "damage",
    [("L2 lost",), ("R3 lost", "R4 lost"), ("L1 femur stuck -30", "R2 coxa slow 0.3")],
    ids=str,
)
def test_a_damaged_walk_agrees_with_an_independent_reference(damage: tuple[str, ...]) -> None:
    motion = damaged(*damage).move(GENOMES)
    assert not np.array_equal(motion["pose"], INTACT["pose"])
    for individual in range(len(GENOMES)):
        pose, stance, slip, margin, slope = reference.walk(
            motion["feet"][individual], motion["centre_of_mass"][individual]
        )
        np.testing.assert_array_equal(motion["stance"][individual, :-1], stance)
        np.testing.assert_allclose(motion["pose"][individual], pose, atol=2e-5)
        np.testing.assert_allclose(motion["slip"][individual, :-1], slip, atol=1e-7)
        np.testing.assert_allclose(motion["margin"][individual, :-1], margin, atol=1e-6)
        np.testing.assert_allclose(motion["slope"][individual, :-1], slope, atol=1e-5)


def test_a_lost_leg_has_no_mass_and_its_foot_is_its_hip() -> None:
    pytest.importorskip("mujoco")
    import rigid_body

    motion = damaged("L1 lost", "R2 lost").move(GENOMES)
    places = rigid_body.feet(motion["joint_angles"][0])
    places[:, 0], places[:, 5] = (0.075, 0.07, 0), (0.025, -0.07, 0)
    np.testing.assert_allclose(motion["feet"][0], places, atol=2e-7)
    masses, middles = rigid_body.links(motion["joint_angles"][0], without=("L1", "R2"))
    assert masses.sum() == pytest.approx(0.8 + 6 * 0.05)
    centre = np.average(middles, axis=1, weights=masses)
    np.testing.assert_allclose(motion["centre_of_mass"][0], centre, atol=2e-7)


def test_mirrored_damage_gives_a_mirrored_walk() -> None:
    left = damaged("L2 lost", "R1 tibia stuck 10").move(GENOMES)
    right = damaged("R2 lost", "L1 tibia stuck 10").move(mirrored(GENOMES))
    np.testing.assert_allclose(right["pose"], left["pose"] * [1, -1, -1], atol=1e-4)


def test_a_body_can_rest_on_the_hips_of_lost_legs() -> None:
    """Without the left legs, the body lies on the line of its left hips."""
    spider = damaged("L1 lost", "L2 lost", "L3 lost", "L4 lost")
    motion = spider.play(np.zeros((1, 2, 24)))
    assert motion["stance"][0, 0].tolist() == [True] * 4 + [True, False, False, True]
    width = body.HIP_Y - motion["feet"][0, 0, 4, 1]
    tilt = np.arctan((body.STANDING_HEIGHT - body.FOOT_RADIUS) / width)
    assert motion["slope"][0, 0] == pytest.approx(tilt, rel=1e-5)


def test_damage_applies_to_played_angles_as_to_genomes() -> None:
    spider = damaged("L2 lost", "R1 femur stuck 20", "R4 coxa slow 0.25")
    moved, played = spider.move(GENOMES), spider.play(INTACT["joint_angles"])
    for channel in spider.channels:
        np.testing.assert_array_equal(played[channel], moved[channel])


def test_a_skeleton_omits_lost_legs_and_keeps_their_hips_as_contacts() -> None:
    spider = damaged("L2 lost", "R1 femur stuck 20")
    skeleton = spider.skeleton(spider.move(GENOMES), 1)
    assert not [name for name in skeleton.names if name.startswith("L2")]
    assert skeleton.segments.shape == (300, 25, 2, 3)
    assert skeleton.contact_names == body.LEGS
    assert skeleton.contacts is not None
    assert skeleton.touching is not None
    assert not skeleton.touching[:, 1].any()
