"""The spider's dimensions: lengths of segments and places of hips, as options and as genes."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait import play_on_twin
from gaitsim.gait.robustness import measure_robustness
from gaitsim.individual import Individual
from gaitsim.steering import individual_subject
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_spider import body
from gaitsim_spider.organism import Spider

FACTORS = {"femur": 1.2, "row2.tibia": 0.8, "L3.coxa": 1.5, "hips.length": 1.1, "hips.width": 0.9}
EVOLVED = Spider(evolve=("tibia", "row1.femur", "hips.width"))


def genomes(spider, count=6, seed=0):
    return spider.genome_space().random(count, np.random.default_rng(seed))


def sizes(leg):
    """Return lengths and hip of a leg of a spider with `FACTORS`, by hand."""
    row, lengths = int(leg[1]), [0.03, 0.08 * 1.2, 0.12]
    if row == 2:
        lengths[2] *= 0.8
    if leg == "L3":
        lengths[0] *= 1.5
    x, y = 0.075 - 0.05 * (row - 1), 0.07 if leg[0] == "L" else -0.07
    return lengths, np.array([x * 1.1, y * 0.9, 0.0])


def test_feet_are_sums_of_the_rotated_segments_of_the_new_lengths():
    spider = Spider(encoding="cpg", dimensions=FACTORS)
    motion = spider.move(genomes(spider, 1))
    angles = motion["joint_positions"][0].reshape(-1, 8, 3).astype(float)
    for at, leg in enumerate(body.LEGS):
        (coxa, femur, tibia), hip = sizes(leg)
        yaw = body.AZIMUTH[at] + angles[:, at, 0]
        lift = np.radians(30) + angles[:, at, 1]
        bend = lift - np.radians(110) + angles[:, at, 2]
        reach = coxa + femur * np.cos(lift) + tibia * np.cos(bend)
        side = 1 if leg[0] == "L" else -1
        foot = np.stack(
            [
                reach * np.sin(yaw),
                side * reach * np.cos(yaw),
                femur * np.sin(lift) + tibia * np.sin(bend),
            ],
            axis=1,
        )
        np.testing.assert_allclose(motion["feet"][0, :, at], hip + foot, atol=1e-6)


@pytest.mark.parametrize("damage", [(), ("R1 lost",)])
def test_half_of_a_segments_mass_grows_with_its_length(damage):
    spider = Spider(dimensions=FACTORS, damage=damage)
    motion = spider.move(genomes(spider, 1))
    ends = dict(zip(*segments_in_body(spider, motion), strict=True))
    total, moment = 0.8, np.zeros((body.FRAMES, 3))
    for leg in body.LEGS:
        if damage and damage[0].startswith(leg):
            continue
        for part, mass, own, nominal in zip(
            body.SEGMENTS, (0.01, 0.02, 0.02), sizes(leg)[0], (0.03, 0.08, 0.12), strict=True
        ):
            grown = mass * (1 + own / nominal) / 2
            total += grown
            moment += grown * ends[f"{leg} {part}"]
    np.testing.assert_allclose(motion["centre_of_mass"][0], moment / total, atol=1e-6)


def segments_in_body(spider, motion):
    """Return the names of the drawn segments, and their middles in the body's frame, m."""
    from gaitsim_spider.kinematics import leg_points

    points = leg_points(motion["joint_positions"][0], body.Sizes(spider.dimensions))
    middles = (points[:, :, :-1] + points[:, :, 1:]) / 2
    return body.JOINTS, np.moveaxis(middles.reshape(body.FRAMES, 24, 3), 1, 0)


@pytest.mark.parametrize("encoding", ["sine", "cpg", "recurrence"])
def test_an_individual_moves_like_its_own_body(encoding):
    spider = EVOLVED.model_copy(update={"encoding": encoding, "world": {"slope": 4.0}})
    population = genomes(spider)
    motion = spider.move(population)
    for index, genome in enumerate(population):
        own, genes = spider.embody(genome)
        assert (own.evolve, len(genes)) == ((), 48)
        alone = own.move(genes[None])
        for name in alone:
            np.testing.assert_array_equal(alone[name][0], motion[name][index], name)


def test_each_individual_is_drawn_with_its_own_lengths():
    population = genomes(EVOLVED)
    motion = EVOLVED.move(population)
    for index in (0, 5):
        skeleton = EVOLVED.skeleton(motion, index)
        ends = skeleton.segments[7].astype(float)
        spans = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        lengths = dict(zip(skeleton.names, spans, strict=True))
        tibia, femur, width = population[index, -3:]
        assert lengths["R4 tibia"] == pytest.approx(0.12 * tibia, rel=1e-5)
        assert lengths["L1 femur"] == pytest.approx(0.08 * femur, rel=1e-5)
        assert lengths["L2 femur"] == pytest.approx(0.08, rel=1e-5)
        left, right = (ends[skeleton.names.index(f"{side}2 coxa"), 0] for side in "LR")
        assert np.linalg.norm(left - right) == pytest.approx(0.14 * width, rel=1e-5)


@given(st.dictionaries(st.sampled_from([*body.DIMENSIONS]), st.floats(0.2, 5.0), max_size=4))
@settings(max_examples=25, deadline=None)
def test_factors_of_one_length_multiply_and_commute(factors):
    expected = body.Sizes(factors).lengths
    again = body.Sizes(dict(reversed(factors.items()))).lengths
    np.testing.assert_array_equal(expected, again)
    tibia = 0.12 * np.prod([factors.get(n, 1.0) for n in ("tibia", "row3.tibia", "R3.tibia")])
    assert expected[0, 6, 2] == pytest.approx(tibia, rel=1e-12)


def test_the_starting_gait_has_the_original_dimensions():
    [start] = EVOLVED.starts().values()
    assert start[-3:].tolist() == [1.0, 1.0, 1.0]
    narrow = Spider(evolve=("tibia",), ranges={"tibia": (1.1, 1.4)})
    assert next(iter(narrow.starts().values()))[-1] == 1.1
    walked = EVOLVED.move(start[None])
    same = Spider().move(next(iter(Spider().starts().values()))[None])
    for name in same:
        np.testing.assert_array_equal(walked[name], same[name], name)


def test_genes_of_dimensions_are_not_mirrored():
    half = Spider(symmetry="alternating", evolve=("femur",))
    whole = half.model_copy(update={"symmetry": "none"})
    population = genomes(half, 3)
    unfolded = half.unfold(population)
    assert half.genome_space().labels[-1] == "femur dimension"
    one, other = half.move(population), whole.move(unfolded)
    np.testing.assert_allclose(one["feet"], other["feet"], atol=1e-6)
    np.testing.assert_array_equal(one["dimensions"], other["dimensions"])


def test_longer_legs_take_longer_steps():
    [start] = Spider().starts().values()
    reached = [
        Spider(dimensions=dict.fromkeys(("coxa", "femur", "tibia"), factor)).move(start[None])
        for factor in (0.8, 1.0, 1.25)
    ]
    distances = [float(motion["pose"][0, -1, 0]) for motion in reached]
    assert all(shorter < longer for shorter, longer in pairwise(distances))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dimensions": {"tibai": 1.2}}, "tibia"),
        ({"evolve": ("shank",)}, "coxa"),
        ({"dimensions": {"tibia": 0.1}}, "0.2 to 5; 1 is 0.12 m"),
        ({"dimensions": {"tibia": float("nan")}}, "finite"),
        ({"dimensions": {"tibia": 1.1}, "evolve": ("tibia",)}, "both set and evolved"),
        ({"evolve": ("tibia", "tibia")}, "listed twice"),
        ({"evolve": ("tibia",), "ranges": {"tibia": (1.2, 0.9)}}, "empty"),
        ({"ranges": {"tibia": (0.9, 1.2)}}, "evolves"),
    ],
)
def test_invalid_dimensions_are_refused(options, message):
    with pytest.raises((GaitsimError, ValidationError)) as error:
        Spider(**options)
    assert message in str(getattr(error.value, "allowed", "")) + str(error.value)


@pytest.fixture(scope="module")
def individual():
    experiment = load_experiment("spider", {"organism.evolve": ["femur", "tibia"]})
    [start] = experiment.starts().values()
    start = np.array([*start[:-2], 1.2, 0.9])
    return Individual(experiment, 0.0, {}, 1, start)


def test_an_individual_knows_its_own_body(individual):
    assert individual.body.design() == "femur × 1.2 = 0.096 m, tibia × 0.9 = 0.108 m"
    own = individual.embodied
    assert (own.body, own.embodied) == (individual.body, own)
    assert len(own.genome) == len(individual.genome) - 2
    np.testing.assert_array_equal(own.motion["pose"], individual.motion["pose"])
    lengths = [link.origin[0] for link in individual.body.rig().links[2:4]]
    assert lengths == pytest.approx([0.03, 0.096])


def test_its_twin_in_physics_has_its_dimensions(individual):
    twin = play_on_twin(individual)
    assert twin.experiment.organism.dimensions == {"femur": 1.2, "tibia": 0.9}
    ends = twin.skeleton.segments[0, twin.skeleton.names.index("L1 femur")]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.096, rel=1e-3)
    steered, _, _ = individual_subject(lambda _: individual.experiment, individual.genome, "it")
    assert steered.organism.dimensions == twin.experiment.organism.dimensions


def test_joint_angles_are_perturbed_on_its_own_body(individual):
    results = measure_robustness(individual, {})
    scores = {one.name: one.score for one in results.perturbations}
    assert scores["played again"] == pytest.approx(results.score)


def test_a_run_shows_the_dimensions_of_its_champion(gaitsim, tmp_path):
    options = "--generations", "1", "--population", "4", "--out", "run"
    gaitsim("run", "spider", "--set", "organism.evolve=['tibia']", *options)
    factor = RunSnapshot(tmp_path / "run").individual().genome[-1]
    expected = f"tibia × {factor:.3g} = {0.12 * factor:.3g} m"
    assert f"design: {expected}" in gaitsim("show", "run").stdout
    assert f"Design: {expected}" in gaitsim("analyse", "run").stdout
    champion = json.loads(gaitsim("show", "run", "--json").stdout)["champion"]
    assert champion["dimensions"] == {"tibia": factor}
    gaitsim("export", "run", "--format", "npz", "--out", "gait.npz")
    played = json.loads(gaitsim("analyse", "run", "--gait", "gait.npz", "--json").stdout)
    assert played["score"] == json.loads(gaitsim("analyse", "run", "--json").stdout)["score"]
