"""Random streams, one for each purpose and generation, so that no generator state is saved."""

from enum import IntEnum

import numpy as np


class Purpose(IntEnum):
    """The purpose of a random stream; changing a number would change the results of every run."""

    INITIAL = 0  # genomes of the first generation
    SELECTION = 1
    CROSSOVER = 2
    MUTATION = 3
    ASK = 4  # genomes of all later generations
    TELL = 5
    STATE = 6  # initial state of a search
    WORLDS = 7  # worlds in which individuals are evaluated
    UNSEEN_WORLDS = 8  # worlds in which a gait is tested
    SCREENING = 9  # seeds of the repeats with which a study selects cells
    CONFIRMATION = 10  # seeds of the repeats with which a study tests the selected cells


def stream(seed: int, generation: int, purpose: Purpose, island: int = 0) -> np.random.Generator:
    """Return the random stream of one purpose in one generation.

    Each island has its own streams; island 0 has the streams of a search without islands.
    """
    return np.random.default_rng([seed, generation, purpose, *([island] if island else [])])
