"""The reflex `network` is a perceptron from measurements to the command."""

import numpy as np
import pytest
from bench import LEGS, observation, start, step

from gaitsim_reflexes.network import NetworkReflex


def feel(population, rng):
    return observation(
        population,
        orientation=rng.normal(0, 0.3, (population, 3)),
        rates=rng.normal(0, 2, (population, 3)),
        heading=rng.normal(0, 0.3, population),
        phase=rng.random((population, 4)),
    )


def test_outputs_are_those_of_a_perceptron_written_out():
    reflex = NetworkReflex(hidden=3, strength=1.5, speed=0.1, turn=45, sideways=0.2, height=0.01)
    count, rng = reflex.weights(LEGS), np.random.default_rng(1)
    assert count == 3 * (8 + 1) + 4 * (3 + 1)
    genes, seen = rng.uniform(-1, 1, (5, count)), feel(5, rng)
    added = step(reflex, seen, start(reflex, 5, genes)).command - seen.command
    for one in range(5):
        w1, b1, w2, b2 = np.split(1.5 * genes[one], [24, 27, 39])
        roll, pitch, yaw = seen.orientation[one]
        angle = 2 * np.pi * seen.phase[one, 0]
        felt = [roll / 0.25, pitch / 0.25, (seen.heading[one] - yaw) / 0.25]
        felt += [*(seen.rates[one] / 2), np.sin(angle), np.cos(angle)]
        hidden = np.tanh(w1.reshape(3, 8) @ felt + b1)
        outputs = np.tanh(w2.reshape(4, 3) @ hidden + b2)
        assert added[one] == pytest.approx(outputs * [0.1, np.pi / 4, 0.2, 0.01])


def test_without_weights_and_while_standing_it_adds_nothing():
    reflex, seen = NetworkReflex(), feel(3, np.random.default_rng(2))
    assert (step(reflex, seen).command == seen.command).all()
    seen.command[:] = [0, 0, 0, 0.01]
    genes = np.ones((3, reflex.weights(LEGS)))
    assert (step(reflex, seen, start(reflex, 3, genes)).command == seen.command).all()
