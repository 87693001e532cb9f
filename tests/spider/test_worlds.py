"""Effects of worlds on the spider, against closed forms."""

from typing import Any

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.legged import downward, draw_joint_errors
from gaitsim_spider import body
from gaitsim_spider.body import FOOT_RADIUS
from gaitsim_spider.organism import Spider

WAVES = np.radians(12) * np.sin(np.arange(120)[:, None] / 8 + np.arange(24))
EVERYTHING = {
    "latency": 0.02,
    "command_rate": 17.0,
    "servo_speed": 0.8,
    "joint_offset": 2.0,
    "initial_pose": 3.0,
    "leg_mass": 1.2,
    "slope": 8.0,
    "side_slope": -5.0,
    "seed": 4.0,
}


def positions(commands: Any = WAVES, **world: float) -> Any:
    """Return the positions of joints that follow commands, (frames, 24) rad."""
    return Spider(world=world).play(commands[None])["joint_positions"][0]


def test_all_conditions_are_tested() -> None:
    assert {*EVERYTHING} == {*Spider().conditions(), "seed"}


def test_offsets_shift_the_joints_but_not_the_commands() -> None:
    world = {"joint_offset": 2.0, "seed": 3.0}
    motion = Spider(world=world).play(WAVES[None])
    off = motion["joint_positions"][0] - WAVES
    np.testing.assert_allclose(
        off, np.tile(draw_joint_errors(world, "joint_offset", 24), (120, 1)), atol=1e-6
    )
    np.testing.assert_allclose(motion["joint_angles"][0], WAVES, atol=1e-7)
    again = Spider(world=world).play(motion["joint_angles"])
    assert all(np.array_equal(motion[name], again[name]) for name in motion)


def test_offset_joints_stay_within_their_limits() -> None:
    wide = positions(joint_offset=30.0)
    assert np.abs(wide).max() == pytest.approx(body.ANGLE_LIMIT)


def test_latency_delays_the_commands() -> None:
    np.testing.assert_array_equal(positions(latency=0.1)[3:], positions()[:-3])
    between = (WAVES[10:-2] + WAVES[9:-3]) / 2
    np.testing.assert_allclose(positions(latency=2.5 / 30)[12:], between[:108], atol=1e-6)


def test_joints_start_with_errors_and_turn_to_their_commands_at_servo_speed() -> None:
    world = {"initial_pose": 6.0, "servo_speed": 0.5, "seed": 2.0}
    still = positions(np.zeros((20, 24)), **world)
    start = draw_joint_errors(world, "initial_pose", 24)
    steps = np.radians(2.5) * np.arange(20)[:, None]
    closed = np.sign(start) * np.maximum(np.abs(start) - steps, 0)
    np.testing.assert_allclose(still, closed, atol=1e-6)


def test_commands_at_a_low_rate_are_held() -> None:
    slow = 0.3 * WAVES
    held = positions(slow, command_rate=10.0)
    np.testing.assert_allclose(held, np.repeat(slow[::3], 3, axis=0), atol=1e-6)


def test_heavier_legs_move_the_centre_of_mass() -> None:
    stretched = np.zeros((1, 20, 24))
    stretched[0, :, [1, 4]] = np.radians(15)  # the first two left legs are up
    centres = [
        Spider(world={"leg_mass": share}).play(stretched)["centre_of_mass"][0, -1].astype(float)
        for share in (0.0, 1.0, 3.0)
    ]
    legs = 8 * (body.COXA_MASS + body.FEMUR_MASS + body.TIBIA_MASS)
    # First moments of the legs about the body's middle: c = share · M / (body + share · legs).
    moment = centres[1] * (body.BODY_MASS + legs)
    assert centres[0] == pytest.approx(0, abs=1e-7)
    assert centres[2] == pytest.approx(3 * moment / (body.BODY_MASS + 3 * legs), abs=1e-6)
    assert np.abs(moment[2]) > 1e-3


def test_a_nominal_world_does_not_change_any_bit() -> None:
    genomes = Spider().genome_space().random(3, np.random.default_rng(0))
    nominal = {name: one.nominal for name, one in Spider().conditions().items()}
    moved, same = Spider().move(genomes), Spider(world=nominal).move(genomes)
    assert all(np.array_equal(moved[name], same[name]) for name in moved)


def test_conditions_that_need_forces_are_refused() -> None:
    with pytest.raises(GaitsimError, match="friction"):
        Spider(world={"friction": 0.5})


def test_a_drawing_shows_the_slope() -> None:
    gait = Spider().starts()["tetrapod"][None]
    spider = Spider(world={"slope": 10.0, "side_slope": 5.0})
    motion = spider.move(gait)
    skeleton = spider.skeleton(motion, 0)
    moved = skeleton.centre[-1] - skeleton.centre[0]
    flat = motion["pose"][0, -1, :2] - motion["pose"][0, 0, :2]
    assert moved[2] == pytest.approx(-flat @ downward(spider.world)[:2], abs=0.01)
    assert moved[2] > 0.3
    above = skeleton.contacts[..., 2] - skeleton.ground.height(skeleton.contacts)
    above *= -downward(spider.world)[2]
    assert np.abs(np.sort(above)[:, :3] - FOOT_RADIUS).max() < 1e-4
    assert skeleton.touching.sum(axis=1).mean() > 2.5
