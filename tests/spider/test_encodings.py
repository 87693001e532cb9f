import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim.experiment import load_experiment
from gaitsim.storage.compatibility import check_start
from gaitsim.storage.creation import without_symmetry
from gaitsim.storage.files.checkpoint import Champion, Start
from gaitsim_spider import body
from gaitsim_spider.encodings import ENCODINGS, largest_amplitude
from gaitsim_spider.organism import Spider

ENCODED = [
    Spider(encoding="sine"),
    Spider(encoding="sine", symmetry="alternating"),
    Spider(encoding="cpg", frequency=2.0),
    Spider(encoding="cpg", symmetry="alternating"),
    Spider(encoding="recurrence"),
]


def angles_of(spider: Spider, count: int = 20, seed: int = 0) -> np.ndarray:
    genomes = spider.genome_space().random(count, np.random.default_rng(seed))
    return np.array(spider.move(genomes)["joint_angles"])


@pytest.mark.parametrize("spider", ENCODED, ids=str)
def test_every_encoding_respects_the_joint_limits(spider: Spider) -> None:
    angles = angles_of(spider)
    assert angles.shape == (20, 300, 24)
    assert angles.dtype == np.float32
    assert np.abs(angles).max() <= body.ANGLE_LIMIT + 1e-6
    assert np.abs(np.diff(angles, axis=1)).max() <= body.STEP_LIMIT + 1e-6
    assert np.abs(np.diff(angles, axis=1)).max() > 0.5 * body.STEP_LIMIT


@given(frequency=st.floats(0.2, 5.0), phase=st.floats(-math.pi, math.pi))
@settings(max_examples=30)
def test_the_largest_amplitude_respects_the_limits_at_any_frequency(
    frequency: float, phase: float
) -> None:
    spider = Spider(frequency=frequency)
    genome = np.repeat([largest_amplitude(frequency), phase, 0.0], [24, 8, 16])
    angles = spider.move(genome[None])["joint_angles"]
    assert np.abs(angles).max() <= body.ANGLE_LIMIT + 1e-6
    assert np.abs(np.diff(angles, axis=1)).max() <= body.STEP_LIMIT + 1e-6


def test_the_largest_amplitude_times_frequency_is_the_published_product() -> None:
    assert math.degrees(largest_amplitude(1.5)) * 1.5 == pytest.approx(23.9, abs=0.05)
    assert largest_amplitude(0.5) == body.ANGLE_LIMIT


def test_sine_follows_the_closed_form() -> None:
    spider = Spider(frequency=1.3)
    genomes = spider.genome_space().random(3, np.random.default_rng(1))
    seconds = np.arange(300) / 30
    amplitude, phase, lag = np.split(genomes, [24, 32], axis=1)
    phases = np.repeat(phase, 3, axis=1)  # a leg's, and its femur's and tibia's lags to it
    phases.reshape(3, 8, 3)[:, :, 1:] += lag.reshape(3, 8, 2)
    angle = 2 * np.pi * 1.3 * seconds[None, :, None] + phases[:, None]
    expected = amplitude[:, None] * np.sin(angle)
    np.testing.assert_allclose(spider.move(genomes)["joint_angles"], expected, atol=1e-6)


@pytest.mark.parametrize("encoding", ["sine", "cpg"])
def test_alternating_right_legs_follow_the_left_ones_half_a_stride_later(encoding: str) -> None:
    spider = Spider(encoding=encoding, symmetry="alternating", frequency=1.5)
    angles = angles_of(spider, 4)
    left, right = angles[:, 150:280, :12], angles[:, 160:290, 12:]  # 10 frames: half of 1/1.5 s
    np.testing.assert_allclose(left, right, atol=0.02 if encoding == "cpg" else 1e-5)


def test_the_recurrence_iterates_the_map_of_the_source() -> None:
    spider = Spider(encoding="recurrence")
    genomes = spider.genome_space().random(5, np.random.default_rng(2))
    angles = spider.move(genomes)["joint_angles"]
    theta = np.zeros((5, 24))
    for frame in range(300):
        np.testing.assert_allclose(angles[:, frame], theta, atol=2e-5)
        step = np.clip(genomes[:, ::2] * angles[:, frame] + genomes[:, 1::2], -0.0872665, 0.0872665)
        theta = np.clip(angles[:, frame] + step, -0.5235988, 0.5235988)


def test_a_child_of_the_recurrence_has_the_mother_s_left_and_the_father_s_right_legs() -> None:
    experiment = load_experiment("spider-recurrence")
    spider, space = experiment.organism, experiment.space()
    mother, father = space.random(2, np.random.default_rng(3))[:, None]
    child = experiment.crossover.cross(mother, father, space, np.random.default_rng(4))
    moved = {
        name: spider.move(genome)["joint_angles"][0]
        for name, genome in (("mother", mother), ("father", father), ("child", child))
    }
    left = [joint.startswith("L") for joint in spider.joint_names()]
    np.testing.assert_array_equal(moved["child"], np.where(left, moved["mother"], moved["father"]))


def test_the_recurrence_ends_at_rest_or_in_a_flip_flop() -> None:
    tail = angles_of(Spider(encoding="recurrence"), 200)[:, -20:]
    np.testing.assert_allclose(tail[:, 2:], tail[:, :-2], atol=2e-3)


def test_the_recurrence_has_no_alternating_form() -> None:
    with pytest.raises(ValueError, match="'sine' or 'cpg'"):
        Spider(encoding="recurrence", symmetry="alternating")


def test_cpg_starts_smoothly_from_standing_still() -> None:
    angles = angles_of(Spider(encoding="cpg"))
    assert np.abs(angles[:, 0]).max() == 0
    assert np.abs(angles[:, 1]).max() < math.radians(0.5)


def test_cpg_settles_on_the_lags_and_amplitudes_of_its_genes() -> None:
    spider = Spider(encoding="cpg", frequency=1.0)
    genomes = spider.genome_space().random(5, np.random.default_rng(3))
    angles = spider.move(genomes)["joint_angles"]
    cycle = np.exp(-2j * np.pi * np.arange(30) / 30)
    # The fundamental frequency of the last stride, for each joint.
    wave = np.einsum("pfj,f->pj", angles[:, -30:], cycle) * 2 / 30
    amplitude, leg_phase, lag = np.split(genomes, [24, 32], axis=1)
    np.testing.assert_allclose(np.abs(wave), amplitude, atol=1e-3)
    lags = np.zeros((5, 8, 3))
    lags[:, :, 1:] = lag.reshape(5, 8, 2)
    expected = (leg_phase[:, :, None] + lags).reshape(5, 24)
    relative = np.exp(1j * (np.angle(wave) - expected))
    # The phases follow the genes relative to the first leg; a common shift is allowed.
    drift = np.angle(relative / relative[:, :1])
    np.testing.assert_allclose(drift[amplitude > 0.02], 0, atol=0.02)


@pytest.mark.parametrize("name", ENCODINGS)
def test_spaces_have_48_named_genes(name: str) -> None:
    space = Spider(encoding=name).genome_space()
    assert space.genes == 48
    assert len(set(space.labels)) == 48


def test_an_atlas_begins_at_the_gait_of_a_symmetric_champion():
    symmetric, atlas = load_experiment("spider"), load_experiment("spider-atlas")
    genome = symmetric.space().random(1, np.random.default_rng(4))[0]
    start = Champion(symmetric.to_toml(), {}, 1, genome, 0.0, {})
    found = without_symmetry(atlas, start)
    check_start(atlas, Start.of(found), "")
    moved, alike = (
        one.organism.move(np.atleast_2d(saved.genome))
        for one, saved in ((symmetric, start), (atlas, found))
    )
    np.testing.assert_allclose(alike["joint_angles"], moved["joint_angles"], atol=1e-6)
    assert without_symmetry(symmetric, start) is start
    assert without_symmetry(atlas, found) is found
