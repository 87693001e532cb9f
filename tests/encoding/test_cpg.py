import math
from dataclasses import replace

import numpy as np
import pytest
from robots import OSCILLATORS, ROBOT, SECONDS, drawn
from scipy.integrate import solve_ivp

START = np.array([0.0, math.pi, 0.5])


def all_to_all(phi, psi, strength):
    return strength * np.sin(phi - phi[:, None] - (psi - psi[:, None])).sum(axis=1)


@pytest.mark.parametrize("coupling", ["all", "leader"])
def test_angles_follow_the_integrated_equations(coupling):
    amplitude, phase, lag, frequency = drawn(3)
    angles = ROBOT.cpg(
        amplitude, phase, lag, frequency, start=START, coupling=coupling, strength=1.5
    )
    for i in range(3):
        speed, psi = 2 * math.pi * frequency[i], phase[i]

        def motion(t, state, speed=speed, psi=psi, size=amplitude[i]):
            phi, r, rate = np.split(state, [3, 9])
            if coupling == "all":
                pull = all_to_all(phi, psi, 1.5)
            else:
                pull = 1.5 * np.sin(speed * t + psi - phi)
            return np.concatenate([speed + pull, rate, 10 * (10 / 4 * (size - r) - rate)])

        state = np.concatenate([START, np.zeros(12)])
        solution = solve_ivp(
            motion, (0, SECONDS[-1]), state, t_eval=SECONDS, rtol=1e-9, atol=1e-9
        ).y
        expected = solution[3:9] * np.sin(solution[OSCILLATORS] + lag[i][:, None])
        np.testing.assert_allclose(angles[i], expected, rtol=0, atol=1e-5)


@pytest.mark.parametrize("coupling", ["all", "leader"])
def test_the_gait_starts_from_a_standing_pose(coupling):
    angles = ROBOT.cpg(*drawn(20), start=START, coupling=coupling)
    assert (angles[:, :, 0] == 0).all()
    assert np.abs(angles[:, :, 1]).max() < 0.01


def test_oscillators_that_follow_a_leader_settle_on_the_sine_encoding():
    values = drawn(20)
    longer = replace(ROBOT, frames=1000)
    settled = longer.cpg(*values, start=START, coupling="leader", strength=4.0)
    np.testing.assert_allclose(settled[..., -50:], longer.sine(*values)[..., -50:], atol=1e-6)


def test_oscillators_coupled_to_all_settle_on_the_phase_differences_of_their_genes():
    amplitude, phase, lag, _ = drawn(20)
    longer = replace(ROBOT, frames=2000)  # 40 s, of which the last 1 s is one stride
    settled = longer.cpg(amplitude, phase, lag, 1.0, start=START)[..., -50:]
    wave = settled @ np.exp(-2j * math.pi * np.arange(50) / 50) * 2 / 50
    np.testing.assert_allclose(np.abs(wave), amplitude, atol=1e-6)
    shift = np.exp(1j * (np.angle(wave) - phase[:, OSCILLATORS] - lag))
    np.testing.assert_allclose(np.angle(shift / shift[:, :1]), 0, atol=1e-4)


@pytest.mark.parametrize("coupling", ["all", "leader"])
def test_an_individual_has_the_same_bits_alone_and_in_a_population(coupling):
    values = drawn(5)
    together = ROBOT.cpg(*values, start=START, coupling=coupling)
    for i in range(5):
        one = (value[i : i + 1] for value in values)
        alone = ROBOT.cpg(*one, start=START, coupling=coupling)
        assert (alone[0] == together[i]).all()
