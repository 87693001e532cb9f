"""Damaged walkers: lost legs, and stuck, weak or slow joints."""

import math

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.plan import leg_at, next_leg, plan_of
from gaitsim_walker.machine import Machine
from gaitsim_walker.organism import Walker

SHORT, LEG = 1.0, 0.9  # s; kg, a thigh and a shank
STUCK = "near fore knee stuck -20"


def walker(*damage, **options):
    return Walker(legs=4, symmetry="none", duration=SHORT, damage=damage, **options)


def trot(*damage, **options):
    one = walker(*damage, **options)
    return one.move(one.starts()["trot"][None])


def test_a_lost_leg_has_no_mass_and_no_force():
    machine = Machine(walker("far hind lost").surroundings(60), np.zeros(8))
    masses = [sum(body.mass for body in machine.space.bodies)]
    intact, motion = trot(), trot("far hind lost")
    masses.append(motion["weight"][0] / 9.81)
    assert masses == pytest.approx([intact["weight"][0] / 9.81 - LEG] * 2)
    for channel in ("joint_angles", "joint_positions", "torque", "stall_torque"):
        assert not motion[channel][..., 6:].any(), channel
        assert motion[channel][..., :6].any(), channel
    assert not motion["load"][:, :, 3].any()
    # Three legs at rest carry what remains of the body: the sum of forces is its weight.
    still = walker("far hind lost", torque_limit=100.0).play(np.zeros((1, 20, 8)))
    assert still["load"][0, 3:, :, 1].sum(axis=1).mean() == pytest.approx(
        still["weight"][0], rel=0.1
    )


def test_a_stuck_joint_keeps_its_angle_without_its_servo():
    motion = trot(STUCK, "far fore hip stuck")
    angles = np.degrees(motion["joint_positions"][0])
    assert np.abs(angles[:, 1] + 20).max() < 1
    assert np.abs(angles[:, 4]).max() < 1
    assert not motion["torque"][..., [1, 4]].any()
    assert np.ptp(angles[:, [0, 2]], axis=0).min() > 5  # the other joints move


def test_weak_and_slow_joints_stay_below_their_limits():
    intact, weak, hip = trot(), trot("near hind hip weak 0.1"), 2  # near hind hip
    assert intact["torque"][..., hip].max() > 1.6 >= weak["torque"][..., hip].max() - 1e-6
    fastest = []
    for damage in ((), ("near hind hip slow 0.05",)):
        motion = trot(*damage, gravity=0.0)  # impacts would turn a servo faster
        fastest.append(np.abs(np.diff(motion["joint_positions"][0, :, hip])).max() * 60)
    limit = 0.05 * walker().speed_limit
    assert fastest[0] > 2 * limit
    assert fastest[1] < 1.1 * limit
    held = trot("near hind hip slow 0")["joint_positions"][0, :, hip]
    assert np.abs(held).max() < math.radians(1)


def test_other_legs_follow_the_same_commands():
    intact, motion = trot(), trot("far hind lost", STUCK)
    others = [0, 2, 3, 4, 5]
    assert np.array_equal(intact["joint_angles"][..., others], motion["joint_angles"][..., others])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ("near lost", "unknown leg"),
        ("near fore knee stuck 60", "-50° to 50°"),
        ("near fore ankle weak", "unknown joint"),
    ],
)
def test_impossible_damage_is_refused(damage, message):
    with pytest.raises(GaitsimError, match=message):
        walker(damage)


def test_the_plan_separates_near_and_far_legs():
    one = walker()
    plan = plan_of(one.skeleton(one.play(np.zeros((1, 2, 8))), 0), one.leg_joints())
    assert [leg_at(plan, column, 7, (20, 8)) for column in (2, 17)] == ["far hind", "near hind"]
    assert next_leg(plan, "near fore", 0, 1) == "far fore"
