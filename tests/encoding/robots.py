"""A body with oscillators that drive one, two and three joints."""

import numpy as np

from gaitsim.encoding import Oscillators

OSCILLATORS = np.array([0, 1, 1, 2, 2, 2])
ROBOT = Oscillators(OSCILLATORS, frames=90, frame_rate=50.0)
SECONDS = np.arange(90) / 50.0


def drawn(population, seed=0):
    """Amplitudes, phases, lags and frequencies of a population."""
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(0.1, 1, (population, 6)),
        rng.uniform(-np.pi, np.pi, (population, 3)),
        rng.uniform(-np.pi, np.pi, (population, 6)),
        rng.uniform(0.5, 2, population),
    )
