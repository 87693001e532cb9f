"""The walker's physics against closed forms."""

import math

import numpy as np
import pytest

from gaitsim_walker.machine import Machine
from gaitsim_walker.organism import Walker
from gaitsim_walker.surroundings import STEP

G = 9.81


def machine(pose=None, **options):
    walker = Walker(**options)
    return Machine(walker.surroundings(600), np.zeros(2 * walker.legs) if pose is None else pose)


def lifted(machine, height=100.0):
    """Move a machine high above the ground, and return it."""
    for body in machine.bodies:
        body.position += (0, height)
    return machine


def total_mass(machine):
    return sum(body.mass for body in machine.bodies)


def centre(machine):
    """Return the centre of mass, (2,) m."""
    sums = sum(body.mass * np.array(body.position) for body in machine.bodies)
    return sums / total_mass(machine)


def momentum(machine):
    """Return the linear momentum, and the angular momentum about the origin, (3,)."""
    whole = np.zeros(3)
    for body in machine.bodies:
        x, z = body.position
        push = body.mass * np.array(body.velocity)
        whole += [*push, body.moment * body.angular_velocity + x * push[1] - z * push[0]]
    return whole


def energy(machine, gravity=G):
    """Return the sum of kinetic and potential energy, J."""
    return sum(
        body.kinetic_energy + body.mass * gravity * body.position.y for body in machine.bodies
    )


def swing(machine, step):
    """Swing the joints back and forth at different rates."""
    for number, joint in enumerate(machine.joints):
        joint.motor.rate = 3 * math.sin(step * STEP * (5 + number))


@pytest.mark.parametrize("legs", [2, 4])
def test_the_whole_body_falls_freely(legs):
    falling = lifted(machine(legs=legs))
    start, steps = centre(falling), 240
    for step in range(steps):
        swing(falling, step)  # motion of the legs does not change the fall of the whole body
        falling.space.step(STEP)
    fallen = start - centre(falling)
    # pymunk moves, then accelerates: after n steps g dt² n (n − 1)/2, less than ½ g t² by g t dt/2.
    assert fallen[1] == pytest.approx(G * STEP**2 * steps * (steps - 1) / 2, abs=1e-6)
    assert fallen[1] == pytest.approx(G / 2, abs=G * STEP / 2 + 1e-6)
    assert fallen[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("legs", [2, 4])
def test_servos_change_no_momentum(legs):
    floating = lifted(machine(legs=legs, gravity=0), 1.0)
    fastest = 0.0
    for step in range(480):
        swing(floating, step)
        floating.space.step(STEP)
        fastest = max(fastest, *(abs(body.angular_velocity) for body in floating.bodies))
        assert momentum(floating) == pytest.approx(0, abs=1e-3)
    assert fastest > 2  # rad/s: the legs have moved


def test_without_torque_and_contact_energy_is_conserved():
    # Free joints with initial speeds form a chain whose parts exchange kinetic energy.
    floating = lifted(machine(gravity=0, torque_limit=0))
    floating.bodies[0].angular_velocity = 2.0
    for joint in floating.joints:
        assert joint.motor.max_force == 0
    floating.space.step(STEP)  # the constraints absorb the initial speeds
    before = energy(floating, gravity=0)
    for _ in range(60):
        floating.space.step(STEP)
        assert energy(floating, gravity=0) <= before * 1.001
    assert energy(floating, gravity=0) == pytest.approx(before, rel=0.1)


def test_at_rest_the_ground_carries_the_weight():
    walker = Walker()
    motion = walker.play(np.zeros((1, 601, 8)))
    settled = slice(60, None)
    load = motion["load"][0, settled]
    assert load[..., 1].sum(axis=1) == pytest.approx(walker.plan.mass * G, rel=1e-3)
    assert load[..., 0].sum(axis=1) == pytest.approx(0, abs=0.05)
    position = motion["torso"][0, settled]
    assert np.ptp(position, axis=0) == pytest.approx(0, abs=1e-4)
    assert np.abs(motion["pitch"]).max() < 1e-4
    assert motion["slip"][0, settled].sum() < 1e-4
    assert motion["energy"][0, -1] < 0.1
    assert (np.abs(load[..., 0]) <= walker.friction * load[..., 1] + 1e-9).all()


def test_at_rest_energy_does_not_grow():
    standing = machine()
    for _ in range(240):
        standing.space.step(STEP)
    before = energy(standing)
    for _ in range(2400):
        standing.space.step(STEP)
        assert energy(standing) < before + 0.01


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_sliding_feet_decelerate_the_body_by_mu_g(friction):
    sliding = machine(friction=friction, torque_limit=1000)
    for _ in range(240):
        sliding.space.step(STEP)
    for body in sliding.bodies:
        body.velocity = (2.0, 0.0)
    steps, mass = 96, total_mass(sliding)
    for _ in range(steps):
        sliding.space.step(STEP)
    slowed = 2.0 - momentum(sliding)[0] / mass
    assert slowed == pytest.approx(friction * G * steps * STEP, rel=0.03)


def test_without_friction_nothing_walks():
    walker = Walker(friction=0, symmetry="alternating", duration=3)
    motion = walker.move(walker.genome_space().random(3, np.random.default_rng(0)))
    floating = motion["load"][..., 0]
    assert np.abs(floating).max() < 1e-5  # N


def test_servos_keep_their_torque_limit():
    walker = Walker(torque_limit=4.0, duration=2)
    motion = walker.move(walker.genome_space().random(4, np.random.default_rng(0)))
    assert motion["torque"].max() == pytest.approx(4.0)


def test_weak_servos_cannot_hold_the_body():
    held, dropped = (
        Walker(torque_limit=limit).play(np.zeros((1, 61, 8)))["height"][0] for limit in (15, 0.2)
    )
    assert held.min() > 0.99 * held[0]
    assert dropped.min() < 0.7 * dropped[0]  # down to the mechanical stops


def test_a_servo_turns_a_free_leg_to_its_command():
    # Without load, the error of a servo decreases as e^(−gain t), up to its speed limit.
    walker = Walker(gravity=0, speed_limit=100)
    told = np.zeros((1, 31, 8))
    told[:, 1:, 1] = 0.4
    motion = walker.play(told)
    reached = motion["joint_positions"][0, :, 1]
    seconds = np.arange(31) / 60
    assert reached == pytest.approx(0.4 * (1 - np.exp(-15 * seconds)), abs=0.03)


def test_shorter_time_steps_hardly_change_a_gait():
    # Four legs trot on the spot for a time in which small differences hardly grow.
    seconds = np.arange(61) / 60
    told = np.zeros((1, 61, 8))
    for leg, phase in enumerate((0.0, math.pi, math.pi, 0.0)):
        told[0, :, 2 * leg + 1] = 0.3 * np.sin(2 * math.pi * 1.5 * seconds + phase)
    coarse, fine = (Walker(dt=dt).play(told) for dt in (STEP, STEP / 4))
    assert coarse["height"] == pytest.approx(fine["height"], abs=0.01)
    assert coarse["joint_positions"] == pytest.approx(fine["joint_positions"], abs=0.1)
    assert coarse["energy"][0, -1] == pytest.approx(fine["energy"][0, -1], rel=0.2)
