"""The walker as a plugin: genomes, channels, options, skeleton and reproducibility."""

import numpy as np
import pytest

from gaitsim_walker import body
from gaitsim_walker.organism import Walker

SHORT = 2.0  # s


def genomes(walker, count, seed=0):
    return walker.genome_space().random(count, np.random.default_rng(seed))


def same(one, other):
    """Return whether two motions have the same bits in every channel."""
    return all(np.array_equal(one[name], other[name]) for name in one)


@pytest.mark.parametrize(
    ("options", "genes"),
    [
        ({}, 25),
        ({"symmetry": "alternating"}, 13),
        ({"legs": 2}, 13),
        ({"legs": 2, "symmetry": "alternating"}, 7),
        ({"encoding": "cpg"}, 25),
    ],
)
def test_every_gene_has_a_label_and_changes_the_motion(options, genes):
    walker = Walker(duration=0.5, **options)
    space = walker.genome_space()
    assert space.genes == genes
    assert len(set(space.labels)) == genes
    motion = walker.move(genomes(walker, 3))
    assert set(motion) == set(walker.channels)
    assert motion["joint_angles"].shape == (3, 31, 2 * walker.legs)
    assert len(walker.joint_names()) == 2 * walker.legs
    for values in motion.values():
        assert np.isfinite(values).all()


@pytest.mark.parametrize("encoding", ["sine", "cpg"])
def test_playing_the_angles_of_a_genome_gives_the_same_bits(encoding):
    walker = Walker(duration=SHORT, encoding=encoding)
    moved = walker.move(genomes(walker, 5, seed=1))
    assert (moved["lasted"] < SHORT).any()  # long enough for falls
    given = moved["joint_angles"].copy()
    played = {**walker.play(given)}
    played.pop("stride_frequency")  # estimated, as the genome is unknown
    assert same(played, moved)
    assert np.array_equal(given, moved["joint_angles"])


def test_angles_beyond_the_limits_are_clipped():
    played = Walker().play(np.full((1, 5, 8), 3.0))["joint_angles"]
    assert played[0, :, 0] == pytest.approx(body.HIP_LIMIT)
    assert played[0, :, 1] == pytest.approx(body.KNEE_LIMIT)


def test_an_alternating_gait_moves_the_far_legs_half_a_stride_later():
    walker = Walker(symmetry="alternating", duration=5)
    genome = genomes(walker, 1)
    genome[0, -1] = 1.5  # Hz: a stride of 40 frames
    commands_of_both = walker.move(genome)["joint_angles"]
    played = Walker(duration=5).play(commands_of_both)
    assert same(played, walker.play(commands_of_both))
    lasted = int(played["lasted"][0] * 60)
    commands_of_both = commands_of_both[0, :lasted]
    assert lasted > 30
    assert commands_of_both[20:, :4] == pytest.approx(commands_of_both[:-20, 4:], abs=1e-9)


def test_the_skeleton_stands_where_the_body_is():
    walker = Walker(duration=0.5)
    motion = walker.play(np.zeros((1, 31, 8)))
    skeleton = walker.skeleton(motion, 0)
    assert skeleton.segments.shape == (31, 12, 2, 3)
    assert (skeleton.segments[..., 1] == 0).all()
    feet = skeleton.segments[:, 5::2, 1]
    assert feet == pytest.approx(skeleton.contacts, abs=1e-12)
    assert feet[..., 2] == pytest.approx(body.FOOT_RADIUS, abs=1e-3)
    lengths = np.linalg.norm(np.diff(skeleton.segments[:, 4:], axis=2)[:, :, 0], axis=-1)
    assert lengths == pytest.approx(body.LIMB)
    assert skeleton.touching[5:].all()


def test_the_recorded_pose_is_the_simulated_one():
    # Compare the feet that follow from the recorded pose with those of pymunk's bodies.
    from gaitsim_walker.machine import Machine
    from gaitsim_walker.surroundings import STEP

    walker = Walker()
    machine = Machine(walker.surroundings(10), np.radians([10.0, 20, -5, 0, 3, -20, 8, 30]))
    machine.bodies[0].angular_velocity = 1.0
    for _ in range(10):
        machine.space.step(STEP)
    position = np.array(machine.bodies[0].position)
    joints = np.array(machine.joint_angles())
    feet = body.leg_points(walker.plan, position, np.array(machine.bodies[0].angle), joints)[:, 2]
    simulated = [limb.local_to_world((0, -body.LIMB / 2)) for limb in machine.bodies[2::2]]
    assert feet == pytest.approx(np.array(simulated), abs=1e-3)


def test_after_a_fall_positions_stay_constant_and_the_rest_is_0():
    walker = Walker(legs=2, duration=5)
    motion = walker.play(np.zeros((1, 301, 4)))  # nothing balances it
    fell = round(motion["lasted"][0] * 60) + 1
    assert 20 < fell < 200
    for name in ("joint_angles", "joint_positions", "torso", "pitch", "energy", "foot_positions"):
        assert (motion[name][0, fell:] == motion[name][0, fell]).all(), name
    for name in ("torso_velocity", "torque", "load", "slip"):
        assert (motion[name][0, fell + 1 :] == 0).all(), name


def test_uneven_ground_depends_only_on_its_seed():
    one, again, other = (
        Walker(world={"unevenness": 0.05, "seed": seed}).surroundings(600).ground
        for seed in (0, 0, 1)
    )
    assert one == again
    assert one != other
    assert 0 <= min(one.z) <= max(one.z) <= 0.05
    longer = Walker(world={"unevenness": 0.05}).surroundings(1200).ground
    assert longer.height(17.3) == one.height(17.3)
    assert longer.height(-17.3) == one.height(-17.3)


def test_feet_stand_on_the_ground_that_is_drawn():
    walker = Walker(world={"unevenness": 0.05}, duration=SHORT)
    skeleton = walker.skeleton(walker.move(genomes(walker, 1)), 0)
    assert Walker().skeleton(Walker(duration=SHORT).move(genomes(walker, 1)), 0).ground is None
    feet = skeleton.contacts[skeleton.touching]
    assert len(feet) > 20
    above = feet[:, 2] - np.interp(feet[:, 0], *skeleton.ground.T)
    # A round foot next to a corner touches the steeper side, and sinks in when it lands hard.
    assert np.median(above) == pytest.approx(body.FOOT_RADIUS, abs=0.001)
    assert np.allclose(above, body.FOOT_RADIUS, atol=0.01)


def test_an_unstable_simulation_fails_without_affecting_others(monkeypatch):
    monkeypatch.setattr("gaitsim_walker.machine.FASTEST", 0.05)
    walker = Walker(duration=0.5)
    swing = 0.5 * np.sin(np.arange(31) / 3)
    commands_of_both = np.stack([np.zeros((31, 8)), np.repeat(swing[:, None], 8, axis=1)])
    motion = walker.play(commands_of_both)
    assert list(motion.failures) == [1]
    assert "became unstable after" in motion.failures[1]
    assert all(np.isfinite(values).all() for values in motion.values())
