"""Effects of worlds on the walker, against closed forms."""

import math

import numpy as np
import pytest

from gaitsim.contracts import Motion
from gaitsim.legged import delay_angles, draw_joint_errors
from gaitsim_walker import body
from gaitsim_walker.organism import Walker

G = 9.81


def standing(seconds: float = 3.0, **world: float) -> Motion:
    """Return the motion of a strong four-legged walker that stands."""
    walker = Walker(torque_limit=1000, world=world)
    return walker.play(np.zeros((1, round(seconds * 60) + 1, 8)))


WAVES = 0.2 * np.sin(np.arange(91)[:, None] / 5 + np.arange(8))


def waving(commands: np.ndarray = WAVES, gravity: float = G, **world: float) -> Motion:
    """Return the motion of a walker that waves its legs."""
    return Walker(gravity=gravity, world=world).play(commands[None])


def test_it_slides_on_slopes_steeper_than_its_friction():
    friction = 0.3
    edge = math.degrees(math.atan(friction))
    hold_commands = standing(friction=friction, slope=edge - 2)["torso"][0, :, 0]
    assert abs(hold_commands[-1] - hold_commands[60]) < 1e-3
    steeper = math.radians(edge + 2)
    speed = standing(friction=friction, slope=math.degrees(steeper))["torso_velocity"][0, :, 0]
    gained = (speed[-1] - speed[60]) / (len(speed) - 61) * 60
    down = G * (math.sin(steeper) - friction * math.cos(steeper))
    assert gained == pytest.approx(-down, rel=0.05)


def test_the_ground_carries_its_weight_on_a_slope():
    motion = standing(mass=1.2, slope=10.0, friction=1.0)
    weight = 1.2 * Walker().plan.mass * G
    assert motion["weight"][0] == pytest.approx(weight)
    forces = motion["load"][0, 60:].sum(axis=1)
    assert forces[:, 1] == pytest.approx(weight * math.cos(math.radians(10)), rel=1e-3)
    assert forces[:, 0] == pytest.approx(weight * math.sin(math.radians(10)), rel=1e-2)


def test_latency_delays_the_commands():
    late = waving(latency=3 / 60)["torso"]
    np.testing.assert_array_equal(late, waving(delay_angles(WAVES, 3))["torso"])
    # A delay between whole steps interpolates.
    steps = [waving(gravity=0.0, latency=n / 240)["joint_positions"][0, 30] for n in (4, 4.5, 5)]
    assert np.abs(steps[2] - steps[0]).max() > 2e-3
    assert steps[1] == pytest.approx((steps[0] + steps[2]) / 2, abs=1e-4)


def test_commands_at_a_low_rate_are_held():
    every_second = np.repeat(WAVES[::2], 2, axis=0)[:91]
    hold_commands = waving(command_rate=30.0)["torso"]
    np.testing.assert_array_equal(hold_commands, waving(every_second)["torso"])


def test_joints_have_initial_and_constant_errors():
    still = {"gravity": 0.0, "torque_limit": 1000.0}
    for name, end in (("joint_offset", 1.0), ("initial_pose", 0.0)):
        world = {name: 2.0, "seed": 3.0}
        off = draw_joint_errors(world, name, 8)
        assert 0.5 < np.degrees(off).std() < 4
        found = Walker(**still, world=world).play(np.zeros((1, 121, 8)))["joint_positions"][0]
        assert found[0] == pytest.approx(off, abs=1e-12)
        assert found[-1] == pytest.approx(end * off, abs=1e-3)


def test_a_push_changes_the_velocity_of_the_whole_body():
    speed = 0.3
    motion = standing(push=speed, friction=0.0)
    sliding = motion["torso_velocity"][0, -30:, 0].mean()
    assert abs(sliding) == pytest.approx(speed, rel=0.02)
    assert {np.sign(standing(push=speed, seed=n)["torso"][0, -1, 0]) for n in range(6)} == {-1, 1}


def test_skeletons_are_rotated_by_the_slope():
    walker = Walker(world={"slope": 10.0})
    skeleton = walker.skeleton(walker.play(np.zeros((1, 31, 8))), 0)
    rise = math.tan(math.radians(10))
    assert skeleton.ground[:, 1] == pytest.approx(rise * skeleton.ground[:, 0])
    above = (skeleton.contacts[..., 2] - rise * skeleton.contacts[..., 0]) * math.cos(
        math.atan(rise)
    )
    assert above == pytest.approx(body.FOOT_RADIUS, abs=2e-3)
