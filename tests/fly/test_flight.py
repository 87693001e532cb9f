"""Flight against closed forms and SciPy's integrators."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gaitsim.contracts import Motion
from gaitsim_fly import body
from gaitsim_fly.organism import Fly

AIRLESS = {"wing_drag": 0.0, "body_drag": 0.0}


def flown(count: int = 1, seed: int = 0, **options: Any) -> tuple[Fly, Motion]:
    """Return a fly with these options, and the flights of some random networks."""
    fly = Fly(**options)
    return fly, fly.move(fly.genome_space().random(count, np.random.default_rng(seed)))


def matrices(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrices of quaternions w, x, y, z, computed by SciPy."""
    flat = Rotation.from_quat(rotation.reshape(-1, 4), scalar_first=True).as_matrix()
    return flat.reshape(*rotation.shape[:-1], 3, 3)


def test_free_fall() -> None:
    _, motion = flown(**AIRLESS, wing_speed=0.0)
    seconds = np.arange(motion["altitude"].shape[1]) / motion.frame_rate
    np.testing.assert_allclose(motion["altitude"][0, :, 0], -0.5 * 9.81 * seconds**2, atol=1e-9)
    np.testing.assert_allclose(motion["velocity"][0, :, 0, 2], -9.81 * seconds, atol=1e-9)


@pytest.mark.parametrize("options", [{}, {"mass": 1.0, "span": 0.3}, {"air_density": 3.0}])
def test_falling_with_locked_wings_reaches_the_terminal_velocity(options: dict[str, Any]) -> None:
    fly, motion = flown(wing_speed=0.0, duration=5.0, **options)
    area = fly.length * fly.width + fly.span * fly.chord  # body and both triangles
    terminal = math.sqrt(2 * fly.mass * 9.81 / (fly.air_density * 1.2 * area))
    assert -motion["velocity"][0, -1, 0, 2] == pytest.approx(terminal, rel=0.01)
    # Before that, v = v_t tanh(g t / v_t).
    seconds = np.arange(motion["altitude"].shape[1]) / motion.frame_rate
    closed = -terminal * np.tanh(9.81 * seconds / terminal)
    np.testing.assert_allclose(motion["velocity"][0, :, 0, 2], closed, atol=1e-3)


def test_without_air_and_gravity_momentum_and_energy_are_conserved() -> None:
    fly, motion = flown(
        **AIRLESS, gravity=0.0, trials=6, start_spin=20.0, height=0.06, start_speed=3.0
    )
    velocity, spin = motion["velocity"][0], motion["angular_velocity"][0]
    turned = matrices(motion["rotation"][0])
    momentum = np.einsum("ftij,j,ftkj,ftk->fti", turned, fly.mechanics({}).inertia, turned, spin)
    energy = 0.5 * np.einsum("fti,fti->ft", momentum, spin)
    assert (velocity == velocity[:1]).all()
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[:1], momentum.shape), atol=1e-12)
    moving = energy[0] > 0
    assert moving.sum() == 5  # all but the first trial, which is at rest
    np.testing.assert_allclose(energy[:, moving] / energy[0, moving], 1, rtol=1e-3)


def test_free_rotation_agrees_with_scipy() -> None:
    fly, motion = flown(
        **AIRLESS,
        gravity=0.0,
        trials=3,
        wings="asymmetric",
        start_spin=10.0,
        width=0.2,  # three different moments of inertia
    )
    frames = motion["rotation"].shape[1]
    for trial in (1, 2):
        rotation, spin = motion["rotation"][0, :, trial], motion["angular_velocity"][0, :, trial]
        start = matrices(rotation[0])

        def euler(_: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
            own, quaternion = y[:3], y[3:]
            # Euler's equations in the body's frame; q' = ½ q ω.
            w, vector = quaternion[0], quaternion[1:]
            return np.concatenate(
                [
                    -np.cross(own, fly.mechanics({}).inertia * own) / fly.mechanics({}).inertia,
                    [-0.5 * vector @ own],
                    0.5 * (w * own + np.cross(vector, own)),
                ]
            )

        solved = solve_ivp(
            euler,
            (0, 3),
            np.concatenate([start.T @ spin[0], rotation[0]]),
            t_eval=np.linspace(0, 3, frames),
            rtol=1e-10,
            atol=1e-12,
        )
        np.testing.assert_allclose(matrices(rotation), matrices(solved.y[3:].T), atol=1e-3)


def loads(
    fly: Fly, state: NDArray[np.float64], wings: NDArray[np.float64], rates: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return force and torque by the drag law, computed with homogeneous matrices.

    Flapping is differentiated numerically, so that it shares no formula with the compiled code.
    """
    turn = matrices(state[3:7])
    velocity, momentum = state[7:10], state[10:13]
    spin = turn @ ((turn.T @ momentum) / fly.mechanics({}).inertia)
    projected = np.abs(turn) @ [
        fly.width * fly.height,
        fly.length * fly.height,
        fly.length * fly.width,
    ]
    half_rho = 0.5 * fly.air_density
    force = -half_rho * fly.body_drag * projected * np.linalg.norm(velocity) * velocity
    force[2] -= fly.mass * fly.gravity
    torque = np.zeros(3)
    for index, side in enumerate((1, -1)):
        own, rate = wings[3 * index : 3 * index + 3], rates[3 * index : 3 * index + 3]

        def placed(angles: NDArray[np.float64], side: int = side) -> NDArray[np.float64]:
            points = body.wing_points(side, fly.span, fly.chord)
            return body.transform(body.wing_matrix(angles, side, fly.width / 2), points)

        points, step = placed(own), 1e-6
        flapping = (placed(own + step * rate) - placed(own - step * rate)).mean(axis=0) / (2 * step)
        arm = turn @ points.mean(axis=0)
        normal = turn @ np.cross(points[1] - points[0], points[2] - points[0])
        area = np.linalg.norm(normal) / 2
        normal /= np.linalg.norm(normal)
        assert area == pytest.approx(fly.span * fly.chord / 2)
        air = velocity + np.cross(spin, arm) + turn @ flapping
        speed = np.linalg.norm(air)
        if speed == 0:
            continue
        drag = fly.wing_drag * abs(normal @ air) / speed
        pushed = -half_rho * drag * area * np.abs(normal) * speed * air
        force += pushed
        torque += np.cross(arm, pushed)
    return force, torque


@pytest.mark.slow
@pytest.mark.parametrize(("wings", "flight"), [("symmetric", 0), ("asymmetric", 1)])
def test_flapping_flight_agrees_with_scipy(wings: str, flight: int) -> None:
    fly, motion = flown(2, wings=wings, duration=0.15, trials=2, dt=0.00025, start_spin=3.0)
    individual = trial = flight
    angles = motion["wing_angles"][individual, :, trial]
    spin = motion["angular_velocity"][individual, 0, trial]
    turn = matrices(motion["rotation"][individual, 0, trial])
    state = np.concatenate(
        [
            motion["position"][individual, 0, trial],
            motion["rotation"][individual, 0, trial],
            motion["velocity"][individual, 0, trial],
            turn @ (fly.mechanics({}).inertia * (turn.T @ spin)),
        ]
    )
    for frame in range(len(angles) - 1):  # the wings' rates change at each command
        rates = (angles[frame + 1] - angles[frame]) / fly.control_step

        def slope(
            t: float,
            y: NDArray[np.float64],
            first: NDArray[np.float64] = angles[frame],
            rates: NDArray[np.float64] = rates,
        ) -> NDArray[np.float64]:
            force, torque = loads(fly, y, first + t * rates, rates)
            turn = matrices(y[3:7])
            spin = turn @ ((turn.T @ y[10:13]) / fly.mechanics({}).inertia)
            w, vector = y[3], y[4:7]
            quaternion = 0.5 * np.array([-spin @ vector, *(w * spin + np.cross(spin, vector))])
            return np.concatenate([y[7:10], quaternion, force / fly.mass, torque])

        solved = solve_ivp(slope, (0, fly.control_step), state, rtol=1e-6, atol=1e-8)
        state = solved.y[:, -1]
    ended = motion["position"][individual, -1, trial]
    np.testing.assert_allclose(ended, state[:3], atol=2e-3)
    assert np.linalg.norm(motion["velocity"][individual, -1, trial]) > 0.5
    turned = matrices(motion["rotation"][individual, -1, trial])
    np.testing.assert_allclose(turned, matrices(state[3:7]), atol=2e-2)


def test_symmetric_wings_stay_exactly_in_their_plane() -> None:
    _, motion = flown(20)
    assert (motion["position"][..., 1] == 0).all()
    assert np.ptp(motion["position"][..., 0]) > 0.1


def mirrored(fly: Fly, genomes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return networks whose flights are mirrored left to right."""
    each = 3 if fly.wings == "symmetric" else 6
    # Mirroring negates y of position and velocity, and x and z of rotation and spin.
    signs = np.array([1, -1, 1, -1, 1, -1] * 2 + [1] * each, float)
    swap = np.arange(each) if each == 3 else np.array([3, 4, 5, 0, 1, 2])
    inputs, *_, before, outputs = fly.layers
    changed = genomes.copy()
    first = changed[:, : fly.layers[1] * inputs].reshape(-1, fly.layers[1], inputs)
    first *= signs
    first[:, :, 12:] = first[:, :, 12 + swap]
    last = changed[:, -outputs * (before + 1) : -outputs].reshape(-1, outputs, before)
    last[:] = last[:, swap]
    changed[:, -outputs:] = changed[:, -outputs:][:, swap]
    return changed


@pytest.mark.parametrize("wings", ["symmetric", "asymmetric"])
def test_a_mirrored_genome_flies_a_mirrored_flight(wings: Any) -> None:
    # The flight is short, as rounding differs between mirror images, and flight is chaotic.
    fly = Fly(wings=wings, duration=0.5)
    genomes = fly.genome_space().random(10, np.random.default_rng(3))
    straight, other = fly.move(genomes), fly.move(mirrored(fly, genomes))
    np.testing.assert_allclose(
        other["position"], straight["position"] * [1, -1, 1], atol=1e-6, rtol=0
    )
    if wings == "asymmetric":
        assert np.abs(straight["position"][..., 1]).max() > 0.05
        swapped = straight["wing_angles"][..., [3, 4, 5, 0, 1, 2]]
        np.testing.assert_allclose(other["wing_angles"], swapped, atol=1e-6)
