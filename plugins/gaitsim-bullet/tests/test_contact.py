"""Contact with the ground in both engines against closed forms, with blocks and balls.

Blocks and balls get the ground and the contacts of robots, from `build` and `apply_world`.
"""

import math
from typing import NamedTuple

import mujoco
import numpy as np
import pytest

from gaitsim_bullet.body import BulletBody
from gaitsim_bullet.client import open_client
from gaitsim_bullet.ground import BASE
from gaitsim_robot.anatomy import Anatomy
from gaitsim_robot.conditions import apply_world
from gaitsim_robot.simulation import build

GRAVITY = 9.81
BLOCK = (0.10, 0.06, 0.01)  # m, half sides
RADIUS = 0.05  # m
MASS = 0.5  # kg

engines = pytest.mark.parametrize("engine", ["mujoco", "bullet"])
frictions = pytest.mark.parametrize("friction", [0.3, 0.8, 1.1])
directions = pytest.mark.parametrize("direction", [0.0, 30.0, 45.0, 250.0])


def solid(friction, angle=0.0, direction=0.0, *, ball=False):
    """Return a block or a ball on ground that falls by `angle` in a direction, both in degrees."""
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="solid")
    body.add_freejoint()
    kind = mujoco.mjtGeom.mjGEOM_SPHERE if ball else mujoco.mjtGeom.mjGEOM_BOX
    body.add_geom(type=kind, size=[RADIUS, 0, 0] if ball else BLOCK, mass=MASS)
    stance = np.array([0.0, 0.0, RADIUS if ball else BLOCK[2], 1.0, 0.0, 0.0, 0.0])
    anatomy = Anatomy(legs=(), held=(), stance=stance, mass=MASS, length=0.2, trunk=0.2)
    level = build(spec, anatomy, {}, dt=0.004, friction=friction, gravity=GRAVITY)
    down = math.sin(math.radians(angle)) * unit(direction)
    slope = math.asin(-down[0])
    side_slope = math.atan2(-down[1], math.cos(math.radians(angle)))
    world = {"slope": math.degrees(slope), "side_slope": math.degrees(side_slope)}
    return apply_world(level, world)


def unit(direction):
    """Return the unit vector along the ground, (2,), for an angle in degrees."""
    return np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])


class Run(NamedTuple):
    """Places and velocities in each step, (steps, 3), the last force on the ground, and dt."""

    places: np.ndarray
    speeds: np.ndarray
    force: np.ndarray
    dt: float


def play(engine, simulation, seconds, speed=(0.0, 0.0)):
    """Simulate a solid that starts on the ground with a velocity along it, (2,) m/s."""
    model, dt, states, force = simulation.model, simulation.model.opt.timestep, [], np.zeros(3)
    if engine == "mujoco":
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:2] = simulation.anatomy.stance, speed
        for _ in range(round(seconds / dt)):
            mujoco.mj_step(model, data)
            states.append((data.qpos[:3].copy(), data.qvel[:3].copy()))
        mujoco.mj_forward(model, data)
        force = data.qfrc_constraint[:3].copy()
    else:
        pytest.importorskip("pybullet")
        dt /= 2
        with open_client(dt) as client:
            body = BulletBody(client, simulation)
            client.resetBaseVelocity(body.number, [*speed, 0.0], [0.0, 0.0, 0.0])
            for _ in range(round(seconds / dt)):
                contacts = body.step(np.zeros(0))
                qpos, qvel = body.state()
                states.append((qpos[:3], qvel[:3]))
            if BASE in contacts:
                force = np.array(contacts[BASE].force)
    places, speeds = map(np.array, zip(*states, strict=True))
    return Run(places, speeds, force, dt)


def delivered(simulation, run, first=0.0, last=None):
    """Return the impulse of friction divided by the normal impulse, (2,), between two moments.

    A block that starts to slide rocks and bounces, so its normal force is not always its weight.
    """
    begin, end = (
        round(first / run.dt),
        len(run.speeds) - 1 if last is None else round(last / run.dt),
    )
    gained = run.speeds[end] - run.speeds[begin]
    impulse = gained - simulation.model.opt.gravity * run.dt * (end - begin)
    return impulse[:2] / impulse[2]


@directions
@frictions
@engines
def test_a_sliding_block_is_decelerated_by_its_friction(engine, friction, direction):
    simulation = solid(friction)
    run = play(engine, simulation, 0.3, 6 * unit(direction))
    found = delivered(simulation, run)
    np.testing.assert_allclose(found, -friction * unit(direction), atol=0.05 * friction)


@directions
@frictions
@engines
def test_a_block_slides_down_a_steep_slope_by_gravity_minus_friction(engine, friction, direction):
    simulation = solid(friction, math.degrees(math.atan(1.5 * friction)), direction)
    run = play(engine, simulation, 0.5)
    np.testing.assert_allclose(
        delivered(simulation, run, 0.1), -friction * unit(direction), atol=0.05 * friction
    )
    assert run.speeds[-1][:2] @ unit(direction) > 0.5


@directions
@frictions
@engines
def test_a_block_rests_below_the_angle_of_friction_and_slides_above(engine, friction, direction):
    angle = math.degrees(math.atan(friction))
    run = play(engine, solid(friction, 0.95 * angle, direction), 1.0)
    half = len(run.places) // 2
    crept = np.linalg.norm(run.places[-1] - run.places[half]) / (run.dt * (half - 1))
    assert crept < CREEP[engine]
    run = play(engine, solid(friction, 1.05 * angle, direction), 1.0)
    assert run.speeds[-1][:2] @ unit(direction) > 0.1


# m/s: MuJoCo's friction is soft, and yields by 0.07 to 0.22 mm/s.
CREEP = {"mujoco": 5e-4, "bullet": 1e-8}


@directions
@engines
def test_a_ball_rolls_down_a_slope_with_five_sevenths_of_its_acceleration(engine, direction):
    run = play(engine, solid(0.8, 15.0, direction, ball=True), 0.5)
    expected = 5 / 7 * GRAVITY * math.sin(math.radians(15.0)) * 0.4 * unit(direction)
    gained = run.speeds[-1] - run.speeds[-1 - round(0.4 / run.dt)]
    np.testing.assert_allclose(gained[:2], expected, atol=0.01 * np.linalg.norm(expected))


@directions
@engines
def test_a_sliding_ball_keeps_five_sevenths_of_its_speed_when_it_rolls(engine, direction):
    simulation, speed = solid(0.8, ball=True), 3 * unit(direction)
    run = play(engine, simulation, 0.5, speed)
    np.testing.assert_allclose(run.speeds[-1][:2], 5 / 7 * speed, atol=0.01 * 3)
    slides = delivered(simulation, run, last=0.08)  # until 2/7 v / (μ g) = 0.11 s
    np.testing.assert_allclose(slides, -0.8 * unit(direction), atol=0.05 * 0.8)


@engines
def test_a_resting_block_presses_with_its_weight_and_hardly_sinks(engine):
    run = play(engine, solid(0.8), 1.0)
    np.testing.assert_allclose(run.force, [0, 0, MASS * GRAVITY], atol=1e-3 * MASS * GRAVITY)
    assert -2e-4 < run.places[-1][2] - BLOCK[2] < 0  # m
    assert np.abs(run.speeds[-1]).max() < 1e-5
