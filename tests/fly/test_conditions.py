"""Effects of worlds on the fly, against closed forms."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gaitsim.contracts import Motion
from gaitsim.legged import draw_joint_errors
from gaitsim_fly.organism import Fly

NOTHING = {"gravity": 0.0, "wing_drag": 0.0, "body_drag": 0.0}


def flight(outputs: float = 0.0, **options: object) -> Motion:
    """Return the flight of a network with constant outputs, as a share of the limits."""
    fly = Fly(**options)  # type: ignore[arg-type]
    genes = np.zeros((1, fly.genome_space().genes))
    genes[0, -fly.layers[-1] :] = math.atanh(outputs)
    return fly.move(genes)


def angles(outputs: float, **options: object) -> NDArray[np.float64]:
    """Return the wing angles of that flight, (frames, 6) rad."""
    turned: NDArray[np.float64] = flight(outputs, **options)["wing_angles"][0, :, 0]
    return turned


@pytest.mark.parametrize(("mass", "density"), [(0.8, 1.3), (1.5, 1.2), (1.0, 4.8)])
def test_weight_and_drag_balance_at_a_speed_that_air_density_scales(
    mass: float, density: float
) -> None:
    motion = flight(world={"mass": mass, "air_density": density}, wing_speed=0.0, duration=5.0)
    area = 0.3 * 0.1 + 0.5 * 0.3
    terminal = math.sqrt(2 * mass * 0.2 * 9.81 / (density * 1.2 * area))
    assert -motion["velocity"][0, -1, 0, 2] == pytest.approx(terminal, rel=0.002)


def test_the_wind_carries_the_body_along() -> None:
    speed = 2.0
    motion = flight(world={"wind": speed}, wing_speed=0.0, gravity=0.0)
    velocity = motion["velocity"][0, :, 0]
    # Only the front face has drag, as the wings are parallel to the wind.
    # With u = w − v, u' = −k u².
    k = 0.5 * 1.2 * 1.2 * 0.1 * 0.1 / 0.2
    seconds = np.arange(len(velocity)) / motion.frame_rate
    gained = speed - speed / (1 + k * speed * seconds)
    np.testing.assert_allclose(np.abs(velocity[:, 0]), gained, atol=1e-6)
    assert (velocity[:, 1:] == 0).all()


def test_a_push_changes_the_velocity_once() -> None:
    ways = []
    for seed in range(6):
        world = {"push": 0.4, "seed": float(seed)}
        velocity = flight(world=world, wings="asymmetric", **NOTHING)["velocity"][0, :, 0]
        jumps = np.linalg.norm(np.diff(velocity, axis=0), axis=1)
        assert sorted(jumps)[-2:] == pytest.approx([0.0, 0.4])
        assert 0.2 < (np.argmax(jumps) + 0.5) / len(jumps) < 0.81
        ways.append(velocity[-1])
    assert len({way.tobytes() for way in ways}) == 6
    level = flight(world={"push": 0.4}, **NOTHING)["velocity"][0, -1, 0]
    assert np.abs(level).tolist() == [0.4, 0.0, 0.0]  # symmetric wings keep the fly in its plane


def test_latency_delays_the_wings() -> None:
    flap = angles(0.5, world={"latency": 0.025}, wing_speed=1000.0, dt=2e-5, **NOTHING)[:, 0]
    assert flap[:6] == pytest.approx(np.radians([0, 0, 0, 15, 30, 30]))


def test_wings_have_limited_speed_and_constant_errors() -> None:
    world = {"servo_speed": 0.5, "joint_offset": 2.0, "seed": 7.0}
    turned = angles(0.5, world=world, wings="asymmetric", **NOTHING)
    off = draw_joint_errors(world, "joint_offset", 6)
    assert turned[0] == pytest.approx(off)
    assert turned[-1] == pytest.approx(off + np.radians([30, 40, 15, 30, 40, 15]))
    assert np.abs(np.diff(turned, axis=0)).max() == pytest.approx(0.5 * 40 * 0.01)


def test_a_dense_world_shortens_the_time_step() -> None:
    heavy, light = (Fly(world={"mass": mass}).mechanics({"mass": mass}) for mass in (1.0, 0.5))
    assert light.stable_step < 1e-3 < heavy.stable_step
    fly = Fly(world={"mass": 0.5})
    motion = fly.move(fly.genome_space().random(20, np.random.default_rng(0)))
    assert not motion.failures
