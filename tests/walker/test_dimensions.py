"""The walker's dimensions: lengths of thighs, shanks and trunk, as options and as genes."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

from gaitsim.errors import GaitsimError
from gaitsim_walker import body
from gaitsim_walker.machine import Machine
from gaitsim_walker.organism import Walker

FACTORS = {"thigh": 1.25, "shank": 0.8, "trunk": 1.1}
EVOLVED = Walker(duration=1.0, evolve=("shank", "trunk"), dimensions={"thigh": 1.1})


def genomes(walker, count=3):
    return walker.genome_space().random(count, np.random.default_rng(1))


def machine(walker, pose=None):
    surroundings = walker.surroundings(60)
    return Machine(surroundings, np.zeros(2 * walker.legs) if pose is None else pose)


@pytest.mark.parametrize("legs", [2, 4])
def test_masses_and_moments_are_those_of_longer_rods_and_boxes(legs):
    bodies = machine(Walker(legs=legs, dimensions=FACTORS)).bodies
    torso, thigh, shank = bodies[:3]
    assert torso.mass == pytest.approx(6.0 * 1.1)
    assert torso.moment == pytest.approx(6.6 * (0.55**2 + 0.12**2) / 12)
    for limb, mass, length in ((thigh, 0.6 * 1.25, 0.25), (shank, 0.3 * 0.8, 0.16)):
        assert limb.mass == pytest.approx(mass)
        assert limb.moment == pytest.approx(mass * length**2 / 12)
    walker = Walker(legs=legs, dimensions=FACTORS, duration=0.5)
    weight = walker.move(genomes(walker, 1))["weight"][0]
    assert weight == pytest.approx(9.81 * sum(one.mass for one in bodies))


@pytest.mark.parametrize("legs", [2, 4])
@pytest.mark.parametrize("factors", [FACTORS, {"thigh": 0.6}, {"shank": 2.0}])
def test_each_foot_is_below_its_hip_at_rest_and_knees_are_bent_by_60_degrees(legs, factors):
    plan = Walker(legs=legs, dimensions=factors).plan
    points = body.leg_points(plan, np.zeros(2), np.zeros(()), np.zeros(2 * legs))
    np.testing.assert_allclose(points[:, 2, 0], points[:, 0, 0], atol=1e-12)
    thigh, shank = points[:, 1] - points[:, 0], points[:, 2] - points[:, 1]
    lengths = np.linalg.norm(thigh, axis=1), np.linalg.norm(shank, axis=1)
    np.testing.assert_allclose(lengths[0], 0.2 * factors.get("thigh", 1))
    np.testing.assert_allclose(lengths[1], 0.2 * factors.get("shank", 1))
    cosines = (thigh * shank).sum(axis=1) / (lengths[0] * lengths[1])
    np.testing.assert_allclose(cosines, math.cos(math.radians(60)))


def test_the_simulated_parts_are_where_the_lengths_put_them():
    pose = np.radians([10.0, 20, -5, 0, 3, -20, 8, 30])
    walker = Walker(dimensions=FACTORS)
    simulated = machine(walker, pose)
    points = body.leg_points(walker.plan, np.zeros(2), np.zeros(()), pose)
    height = simulated.bodies[0].position.y
    for leg in range(4):
        foot = simulated.bodies[2 + 2 * leg].local_to_world((0, -0.08))
        assert tuple(foot) == pytest.approx(tuple(points[leg, 2] + [0, height]))
    for _ in range(60):  # the joints hold the parts together
        simulated.space.step(1 / 240)
    for thigh, shank in zip(simulated.bodies[1::2], simulated.bodies[2::2], strict=True):
        knees = thigh.local_to_world((0, -0.125)), shank.local_to_world((0, 0.08))
        assert tuple(knees[0]) == pytest.approx(tuple(knees[1]), abs=5e-3)


def test_bending_a_knee_lifts_the_foot_straight_up():
    plan = Walker(dimensions=FACTORS).plan
    knee = 1e-4
    pose = np.ravel([(leg.knee * knee * plan.compensation, knee) for leg in plan.legs])
    moved, rest = (
        body.leg_points(plan, np.zeros(2), np.zeros(()), angles)[:, 2]
        for angles in (pose, np.zeros(8))
    )
    np.testing.assert_allclose(moved[:, 0], rest[:, 0], atol=1e-8)
    assert (moved[:, 1] - rest[:, 1] > 1e-6).all()


@pytest.mark.parametrize("legs", [2, 4])
def test_an_individual_moves_and_is_drawn_like_its_own_body(legs):
    walker = EVOLVED.model_copy(update={"legs": legs})
    population = genomes(walker)
    motion = walker.move(population)
    for index, genome in enumerate(population):
        own, genes = walker.embody(genome)
        assert own.evolve == ()
        alone = own.move(genes[None])
        for name in alone:
            np.testing.assert_array_equal(alone[name][0], motion[name][index], name)
        drawn = walker.skeleton(motion, index)
        np.testing.assert_array_equal(drawn.segments, own.skeleton(alone, 0).segments)
        lengths = np.linalg.norm(np.diff(drawn.segments[7], axis=1)[:, 0], axis=1)
        assert lengths[drawn.names.index(f"{walker.plan.legs[0].name} shank")] == pytest.approx(
            0.2 * genome[-2]
        )
        assert motion["length"][index] == pytest.approx(0.5 * genome[-1])


def test_the_trot_starts_with_the_original_dimensions():
    start = EVOLVED.starts()["trot"]
    assert start[-2:].tolist() == [1.0, 1.0]
    np.testing.assert_array_equal(start[:-2], Walker().starts()["trot"])


def test_a_rig_has_the_lengths_of_its_body():
    rig = Walker(dimensions=FACTORS).rig()
    lengths = np.linalg.norm(np.diff(rig.segments, axis=1)[:, 0], axis=1)
    expected = {"near fore thigh": 0.25, "far hind shank": 0.16, "bottom": 0.55}
    for name, length in expected.items():
        assert lengths[rig.names.index(name)] == pytest.approx(length)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dimensions": {"femur": 1.2}}, "thigh, shank, trunk"),
        ({"evolve": ("torso",)}, "trunk"),
        ({"dimensions": {"thigh": 9.0}}, "0.2 to 5; 1 is 0.2 m"),
        ({"dimensions": {"thigh": 1.1}, "evolve": ("thigh",)}, "both set and evolved"),
    ],
)
def test_invalid_dimensions_are_refused(options, message):
    with pytest.raises((GaitsimError, ValidationError)) as error:
        Walker(**options)
    assert message in str(getattr(error.value, "allowed", "")) + str(error.value)
